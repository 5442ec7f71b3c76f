#pragma once

#include <cstdint>

#include "common/maths/fields.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/engine/contact/contact.h"

namespace haptics {

/// What a tick felt on the way from the device's position to its force: all that is left to do, and to tell, once the
/// force is written. SI units, world frame.
struct ForceResult {
  ForceResult() noexcept {}  // no aggregate: the compiler would clear those in a loop, which takes longer

  /// A client's force on the hand (N, world); call it before the force is computed.
  void add(Vec3 force_N) noexcept {
    adds = true;
    added_N = force_N;
  }

  bool followed = false;     ///< No fault stood in the way: the position was felt.
  std::uint64_t object = 0;  ///< Id of the touched one, 0 when free.
  ContactResult contact;     ///< As it is felt: on dented triangles, with shading and texture.
  Vec3 geometricNormal{0};   ///< Of the contact, before shading and texture; where an observer looks ahead.
  FrictionState friction = FrictionState::kNone;
  Vec3 stickingPoint{0};
  double height_m = 0;     ///< Of the texture.
  Vec3 shadingForce_N{0};  ///< What shading changed of the force.
  ForceComponents force;
  Word<bool> adds = false;         ///< A client adds something to the force:
  Vec3 added_N;                    ///< this, before the limits; else anything.
  std::int64_t keptForMotion = 0;  ///< Of the tick's allowance, units (Allowance).
};

}  // namespace haptics
