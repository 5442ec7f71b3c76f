#pragma once

#include <span>

#include "haptic_server/engine/motion/rigid_body.h"

namespace haptics {

/// How little mass (kg) a body lets a push feel that acts on one of these vertices, in the direction that turns and moves
/// it most: m of a slider, moment over squared arm of a hinge.
[[nodiscard]] double minApparentMass_kg(const RigidBody& body, std::span<const Vec3f> vertices);

/// Spring and damper between the stylus and a body, coupled once a tick, give it more energy than they took when
/// k T^2 + b T is more than so many times its felt mass. Measured: a spring that a body of felt mass m leaves after a push
/// lets it go at up to 2.0 times the stylus' speed at 1, as an elastic impact does; at 2.4 at 2; at 4.5 at 4.
inline constexpr double kMaxCoupling = 1;

/// The share of a stiffness (N/m) and damping (Ns/m) at which a body of this felt mass is stable: 1 or less.
[[nodiscard]] inline double stableStiffnessShare(double mass_kg, double stiffness, double damping,
                                                 double period_s) noexcept {
  const double coupling = (stiffness * period_s + damping) * period_s;
  return coupling > kMaxCoupling * mass_kg ? kMaxCoupling * mass_kg / coupling : 1;
}

/// Between a hand and a body that it holds, beside the spring of the body's stiffness (grasp.h).
struct GraspSprings {
  double damping_Ns_per_m = 0;
  double torsion_Nm_per_rad = 0;
};

/// As stiff as a tick bears, at half of critical damping, where a tick bears that. `hands` may hold it at once.
/// @param apparentMass_kg  minApparentMass_kg().
[[nodiscard]] GraspSprings graspSprings(const RigidBody& body, double apparentMass_kg, double stiffness_N_per_m,
                                        double period_s, int hands) noexcept;

}  // namespace haptics
