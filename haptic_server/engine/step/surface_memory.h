#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "common/maths/vec.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/geometry/triangle_record.h"
#include "haptic_server/engine/surface/friction.h"

namespace haptics {

/// Takes the step out of a switch of force shading: on sharp lines, and where several surfaces of a body hold the IHIP, there
/// is no N_s; where several bodies do, there is one of each. What the switch would change at once fades instead.
struct ShadingFade {
  enum class Mode : std::uint8_t { kOff, kAlone, kHollow, kBetween, kTogether };
  friend constexpr Mode lastOf(Mode) noexcept { return Mode::kTogether; }

  /// Seconds in which what is left falls to 1/e. Shorter is more of a step; longer leaves a wrong direction standing.
  static constexpr double kTime_s = 0.02;

  /// What was shaded in the last tick: one body, one above its dents, none as another holds its dent up, several.
  Word<Mode> mode = Mode::kOff;
  Vec3 turn{0};            ///< What shading added to the unshaded direction in the last tick; world.
  double deepening_m = 0;  ///< The same for the depth.
  Vec3 turnLeft{0};        ///< Of a switch, still to fade.
  double deepeningLeft_m = 0;
  Vec3 springs_N{0};  ///< Of the last tick, in a scene of several bodies; world.
  Vec3 change_N{0};   ///< Of that to the tick before.
  Vec3 left_N{0};     ///< Of a switch to several bodies' shading or back, still to fade.

  HAPTICS_FIELDS(self.mode, self.turn, self.deepening_m, self.turnLeft, self.deepeningLeft_m, self.springs_N,
                 self.change_N, self.left_N);
};

/// Friction on one of the surfaces that hold the IHIP.
struct HeldFriction {
  StickSlip law;
  std::uint64_t object = 0;  ///< Id, 0: none. Unless it is, the rest is of the last tick.
  Vec3 normal{0};            ///< Outward, unit, world: by this the surface is known again.
  Vec3 stickingPoint{0};     ///< World.

  HAPTICS_FIELDS(self.law, self.object, self.normal, self.stickingPoint);
};

/// The sinusoid that the last touchings have left, as a phasor that turns and shrinks: what another touching adds is no step.
struct TapMemory {
  Vec3 cosine_N{0};  ///< World, likewise the sine, which is the force.
  Vec3 sine_N{0};
  double turnCosine = 0, turnSine = 0;  ///< What a tick turns it by and shrinks it to.
  double spent_J = 0;                   ///< Of the budget.
  Vec3 force_N{0};                      ///< In the last tick, on the hand; world.
  std::uint64_t object = 0;             ///< Id of what was touched.

  [[nodiscard]] bool rings() const noexcept { return cosine_N != Vec3(0) || sine_N != Vec3(0); }
  HAPTICS_FIELDS(self.cosine_N, self.sine_N, self.turnCosine, self.turnSine, self.spent_J, self.force_N, self.object);
};

/// What the surface properties of the felt object remember from tick to tick. Written by SurfaceForceModel and
/// adoptScene().
struct SurfaceMemory {
  /// After an edit friction goes on from the force that it was, if that is no more than so many times the new one.
  static constexpr double kMaxFrictionWeight = 4;

  std::uint64_t object = 0;  ///< Id of what was felt in the last tick, 0 for nothing.
  std::array<HeldFriction, ContactState::kMaxHolding> friction;
  double frictionWeight = 1;  ///< The part of friction that is felt, on its way to 1 after an edit.
  ShadingFade fade;
  Vec3 frictionForce_N{0};  ///< Of the last tick; world.
  TapMemory tap;            ///< Written by addTap().

  /// All but what taps have spent, of which there is so much in a second whatever happens.
  void forget() noexcept {
    const double spent_J = tap.spent_J;
    *this = {};
    tap.spent_J = spent_J;
  }

  HAPTICS_FIELDS(self.object, self.friction, self.frictionWeight, self.fade, self.frictionForce_N, self.tap);
};

/// Of one object with bumps, of a texture or of shading, which can be felt before its polygons are touched. Written by
/// SurfaceForceModel.
struct BumpState {
  /// Seconds in which a bump fades in that is already there when the HIP appears in it.
  static constexpr double kFadeIn_s = 0.05;

  Word<std::uint32_t> triangle = kNoTriangle;  ///< Nearest to the HIP, when last looked for.
  Vec3 seenFrom{0};                            ///< The HIP then; object frame.
  double clear_m = 0;                          ///< No bump is within this distance of there.
  double blendWeight = 0;                      ///< The part of the height that is felt.
  double height_m = 0;                         ///< Of the texture, as felt in the last tick.

  HAPTICS_FIELDS(self.triangle, self.seenFrom, self.clear_m, self.blendWeight, self.height_m);
};

static_assert(std::is_trivially_copyable_v<SurfaceMemory> && std::is_trivially_copyable_v<BumpState>);

}  // namespace haptics
