#pragma once

#include <cstdint>

#include "common/maths/fields.h"
#include "common/maths/vec.h"
#include "common/scene/effect_properties.h"
#include "haptic_server/engine/effects/effect_path.h"
#include "haptic_server/engine/force/spring_damper.h"

namespace haptics {

/// What an effect remembers from tick to tick.
struct EffectMemory {
  std::uint64_t object = 0;   ///< Id of what carries it,
  std::uint64_t number = 0;   ///< and which of its effects it is.
  Word<bool> holds = false;   ///< The spring or guide has taken hold; the HIP is in the region.
  std::uint64_t segment = 0;  ///< Of the path: where the target was,
  double part = 0;            ///< and at which part of it.
  double turns = 0;           ///< Of a vibration, 0 to 1.
  Vec3 hip{0}, target{0};     ///< In the last tick, in the effect's frame.
  Vec3 force_N{0};            ///< Likewise, on the hand; world.

  HAPTICS_FIELDS(self.object, self.number, self.holds, self.segment, self.part, self.turns, self.hip, self.target,
                 self.force_N);
};

/// A field of force over position and velocity (README.md), ready for the servo. noexcept, no allocation once it is made.
class EffectField {
 public:
  explicit EffectField(const Effect& effect);

  [[nodiscard]] bool isInWorld() const noexcept { return effect_.frame == Effect::Frame::kWorld; }
  [[nodiscard]] Effect::Trigger trigger() const noexcept { return effect_.trigger; }
  [[nodiscard]] Stiffness stiffness() const noexcept { return {effect_.stiffness_N_per_m, effect_.damping_Ns_per_m}; }
  /// Whether both are of one path, so that a place on one is the same on the other.
  [[nodiscard]] bool hasPathOf(const EffectField& other) const noexcept {
    return effect_.path_m == other.effect_.path_m;
  }
  /// Whether one that comes from elsewhere can be used.
  [[nodiscard]] bool isPlaceOf(const EffectMemory& memory) const noexcept;

  struct Felt {
    Vec3 force_N{0};
    bool jumped = false;  ///< The force stepped by itself: it took hold, let go, or the nearest place is another one.
    double byTime_N = 0;  ///< By how much it changed because of the time alone.
  };
  /// All in the effect's frame.
  /// @param velocity  Of the HIP relative to the frame, m/s.
  [[nodiscard]] Felt felt(EffectMemory& memory, Vec3 hip, Vec3 velocity, double period_s) const noexcept;

 private:
  [[nodiscard]] Felt pull(EffectMemory& memory, Vec3 hip, Vec3 target, Vec3 damped) const noexcept;
  [[nodiscard]] Felt pullToPath(EffectMemory& memory, Vec3 hip, Vec3 velocity) const noexcept;
  [[nodiscard]] Felt keepInTube(EffectMemory& memory, Vec3 hip, Vec3 velocity) const noexcept;
  [[nodiscard]] Vec3 pushOut(double depth_m, Vec3 normal, Vec3 velocity) const noexcept;
  [[nodiscard]] Felt vibrate(EffectMemory& memory, Vec3 hip, double period_s) const noexcept;
  [[nodiscard]] double regionWeight(Vec3 hip) const noexcept;
  [[nodiscard]] Felt inRegion(EffectMemory& memory, Vec3 hip, Vec3 force_N) const noexcept;
  [[nodiscard]] Vec3 limited(Vec3 force_N) const noexcept;

  Effect effect_;
  double reach_m_, release_m_;  // infinite where there is none
  EffectPath path_;
};

}  // namespace haptics
