#pragma once

#include <cstdint>

#include "common/maths/fields.h"
#include "common/maths/vec.h"
#include "common/scene/effect_properties.h"
#include "haptic_server/engine/effects/effect_path.h"
#include "haptic_server/engine/effects/near_mesh.h"
#include "haptic_server/engine/effects/recorded_texture.h"
#include "haptic_server/engine/force/spring_damper.h"

namespace haptics {

/// What an effect remembers from tick to tick.
struct EffectMemory {
  std::uint64_t object = 0;   ///< Id of what carries it,
  std::uint64_t number = 0;   ///< and which of its effects it is.
  Word<bool> holds = false;   ///< The spring or guide has taken hold; the HIP is in the region.
  std::uint64_t segment = 0;  ///< Of the path: where the target was,
  /// And at which part of it. Of inertia: how much of the mass there is. Of one that isActive(): how much of its budget is spent.
  double part = 0;
  double turns = 0;        ///< Of a vibration, 0 to 1; of samples, at which of them it is.
  Vec3 hip{0}, target{0};  ///< In the last tick, in the effect's frame. Of inertia: where the mass is,
  Vec3 velocity{0};        ///< and its velocity.
  Vec3 force_N{0};         ///< Likewise, on the hand; world.

  HAPTICS_FIELDS(self.object, self.number, self.holds, self.segment, self.part, self.turns, self.hip, self.target,
                 self.velocity, self.force_N);
};

/// A field of force over position and velocity (README.md), ready for the servo. noexcept, no allocation once it is made.
class EffectField {
 public:
  /// @param period_s  Of the servo's ticks, for a recorded texture.
  explicit EffectField(const Effect& effect, double period_s = 1e-3);

  [[nodiscard]] const Effect& effect() const noexcept { return effect_; }
  [[nodiscard]] bool isInWorld() const noexcept { return effect_.frame == Effect::Frame::kWorld; }
  [[nodiscard]] Effect::Trigger trigger() const noexcept { return effect_.trigger; }
  [[nodiscard]] Stiffness stiffness() const noexcept { return {effect_.stiffness_N_per_m, effect_.damping_Ns_per_m}; }
  /// Whether it goes on from what the other remembers: both are of one kind, of one path and, where a mass is carried, in one
  /// frame.
  [[nodiscard]] bool goesOnFrom(const EffectField& other) const noexcept {
    return effect_.kind == other.effect_.kind && effect_.path_m == other.effect_.path_m &&
           (effect_.kind != Effect::Kind::kInertia || effect_.frame == other.effect_.frame);
  }
  /// Of one that goesOnFrom() another: what its mass has more is at rest, and a stiffer spring is stretched less, so that the edit
  /// gives no energy.
  void takeOver(const EffectField& before, EffectMemory& memory) const noexcept;
  /// Whether it is felt by what of its object's mesh is near().
  [[nodiscard]] bool isOfMesh() const noexcept { return isOfMesh_; }
  /// That, in the effect's frame. One query or two of the mesh; where they spend the allowance, what they find means nothing.
  [[nodiscard]] NearMesh near(const CollisionMesh& mesh, Vec3 hip, Allowance& allowance) const noexcept;
  /// Whether one that comes from elsewhere can be used.
  [[nodiscard]] bool isPlaceOf(const EffectMemory& memory) const noexcept;

  struct Felt {
    Vec3 force_N{0};
    bool jumped = false;  ///< The force stepped by itself: it took hold, let go, or the nearest place is another one.
    double byTime_N = 0;  ///< By how much it changed because of the time alone.
  };
  /// All in the effect's frame.
  /// @param velocity  Of the HIP relative to the frame, m/s.
  /// @param mesh  near(), of one that isOfMesh().
  [[nodiscard]] Felt felt(EffectMemory& memory, const Vec3& hip, const Vec3& velocity, double period_s,
                          const NearMesh& mesh = {}) const noexcept;

  [[nodiscard]] bool isTexture() const noexcept { return effect_.kind == Effect::Kind::kRecordedTexture; }
  /// Likewise, of one that isTexture(), on the object that carries it where that is touched.
  /// @param normal  Unit, outward; 0: it is not touched.
  /// @param normal_N  Force of the surface along it.
  [[nodiscard]] Felt feltAlong(EffectMemory& memory, TextureMemory& texture, const Vec3& normal, double normal_N,
                               const Vec3& velocity) const noexcept;

  /// It gives the hand energy of its own: a vibration, samples, a recorded texture.
  [[nodiscard]] bool isActive() const noexcept { return isActive_; }
  /// Weaker as the budget of one that isActive() ends.
  /// @param given_J  What it gave the hand on the way to here.
  static void keepToBudget(EffectMemory& memory, Felt& felt, double period_s, double given_J) noexcept;

 private:
  /// How much of a pull over that way is felt; takes hold and lets go.
  [[nodiscard]] double reachWeight(EffectMemory& memory, double far_m, bool& jumped) const noexcept;
  [[nodiscard]] Felt pull(EffectMemory& memory, const Vec3& hip, const Vec3& target, const Vec3& damped) const noexcept;
  [[nodiscard]] Felt pullToMesh(EffectMemory& memory, const Vec3& hip, const Vec3& velocity,
                                const NearMesh& mesh) const noexcept;
  [[nodiscard]] Felt pullToPath(EffectMemory& memory, const Vec3& hip, const Vec3& velocity) const noexcept;
  [[nodiscard]] Felt keepInTube(EffectMemory& memory, const Vec3& hip, const Vec3& velocity) const noexcept;
  [[nodiscard]] Vec3 pushOut(double depth_m, Vec3 normal, const Vec3& velocity) const noexcept;
  [[nodiscard]] Felt carryMass(EffectMemory& memory, const Vec3& hip, const Vec3& velocity, double weight,
                               double period_s) const noexcept;
  [[nodiscard]] Felt vibrate(EffectMemory& memory, double weight, double period_s) const noexcept;
  [[nodiscard]] Felt play(EffectMemory& memory, double weight, double period_s) const noexcept;
  [[nodiscard]] double regionWeight(const Vec3& hip, const NearMesh& mesh) const noexcept;
  [[nodiscard]] static Felt inRegion(EffectMemory& memory, double weight, Vec3 force_N) noexcept;
  [[nodiscard]] Vec3 limited(Vec3 force_N) const noexcept;

  Effect effect_;
  double reach_m_, release_m_;  // infinite where there is none
  bool isOfMesh_, isActive_;
  EffectPath path_;
  RecordedTexture texture_;
};

}  // namespace haptics
