#pragma once

#include <vector>

#include "haptic_server/engine/collision/body_pairs.h"
#include "tests/eval/baselines/global_closest.h"
#include "tests/eval/body_world.h"

namespace haptics::eval {

/// Bodies that springs push apart: Moore & Wilhelms (1988), Collision Detection and Response for Computer Animation. At each
/// point that is inside another body, which findBodyContacts() finds as it does for the production solver, by its depth d
/// and the velocity v of the two bodies there
///
///     F_n = max(k d - c v_n, 0),   |F_t| = min(mu F_n, c |v_t|)   against v_t (regularised Coulomb)
///
/// from where the bodies are as the tick begins; semi-implicit Euler at kPeriod_s moves them. k and c:
/// springStiffness_N_per_m(). The hand is pushed out of every body along the way to its nearest surface (GlobalClosest), by
/// kSpring_N_per_m, and the body by the opposite of that.
/// **Deviations**: a damper takes the place of the softer spring for the way apart. Bodies sleep, all at once when all are
/// still (isStill()), and wake when the hand pushes any. Nothing resists rolling.
class SpringWorld final : public BodyWorld {
 public:
  std::uint64_t add(const MovingSolid& solid, const Pose& pose, bool moves) override;
  [[nodiscard]] ServoObject& object(std::uint64_t id) override { return objects_[id - 1]; }
  void publish() override;
  TelemetrySample tick(Vec3 hip) override;

  [[nodiscard]] const Pose& poseOf(std::uint64_t id) const override { return bodies_[id - 1].pose; }
  [[nodiscard]] const RigidState& stateOf(std::uint64_t id) const override { return states_[id - 1]; }
  [[nodiscard]] double energyOf(std::uint64_t id) const override;
  [[nodiscard]] std::uint64_t waitedTicks() const override { return 0; }

 private:
  [[nodiscard]] Vec3 pushByHand(Vec3 hip);
  void wake();
  void pushApart(const BodyPair& pair);
  void move();

  std::vector<ServoObject> objects_;  // [id - 1], as the next two
  std::vector<Collider> bodies_;
  std::vector<RigidState> states_;
  BodyPairs pairs_;
};

/// The stiffest spring of a point, and its damping, with which a box of this mass (kg; of two that move the reduced one)
/// stands stably on its four corners under semi-implicit Euler with the period h.
///
/// Whatever a box's sides, of its motions that tilt it and move it aside none is stiffer than 16 such springs or damped by
/// more than 16 such dampers on its mass, those of friction included. Critically damped as if it were both, with
/// w = h sqrt(16 k / m) and c = 2 w m / (16 h), it is stable while w^2 + 4 w <= 4: 4.3 kN/m and 10 Ns/m for 0.1 kg at 1 kHz.
[[nodiscard]] double springStiffness_N_per_m(double mass_kg);
[[nodiscard]] double springDamping_Ns_per_m(double mass_kg);

/// The hand by the penalty method, alone and among bodies that springs push apart.
class SpringsBetweenBodies final : public GlobalClosest {
 public:
  [[nodiscard]] std::unique_ptr<BodyWorld> makeBodyWorld() const override { return std::make_unique<SpringWorld>(); }
};

}  // namespace haptics::eval
