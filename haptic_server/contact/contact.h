#pragma once

#include <span>
#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/geometry/surface.h"

// Interface sketch: the contact room completes it.
namespace haptics {

/// One object as the contact core sees it in a tick. Written by the step before followContact().
struct Body {
  const Surface* surface = nullptr;
  Pose previous;        ///< At the last tick.
  Pose current;         ///< At this tick.
  bool moving = false;  ///< previous != current.
  // ... derived: centre and axes of the bounding sphere in the world, kept by update()
  void update() noexcept;
};

struct ContactState;  ///< Trivially copyable; everything the contact core remembers from tick to tick.

/// What the contact core found: the rest of the step reads only this.
struct ContactResult {
  bool touching = false;
  int body = -1;            ///< Index into bodies, -1 when free.
  Vec3 ihip{0};             ///< World; equals the HIP when free.
  Vec3 normal{0};           ///< World, unit, outward geometric normal at the IHIP; zero when free.
  double penetration_m = 0; ///< |IHIP - HIP|, 0 when free.
  PrimitiveId primitive;    ///< Canonical numbering.
};

void place(ContactState& state, Vec3 hip) noexcept;  ///< Free at hip: attach, re-attach.
[[nodiscard]] ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip) noexcept;

/// Where each body of an adopted scene comes from.
struct BodyOrigin {
  int before = -1;       ///< Its index in the bodies before the adoption, -1 when it is new.
  bool changed = true;   ///< Its surface or its pose is another one (or it is new).
};
/// Carries the state over an adoption. Contact with an unchanged body goes on as it was; otherwise the proxy (IHIP) stays
/// where it is in the world, is pushed out of every changed closed body that it finds itself in, and the next
/// followContact() finds what holds it. Returns true when the contact that was held could not be carried as it was.
[[nodiscard]] bool reseat(ContactState& state, std::span<const Body> bodies, std::span<const BodyOrigin> origins) noexcept;

}  // namespace haptics
