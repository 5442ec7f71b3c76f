#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "common/maths/vec.h"
#include "common/telemetry/motion_state.h"
#include "haptic_server/engine/motion/mass_properties.h"

namespace haptics {

/// Half of space that a body rests on or slides along: {x : normal . x <= offset}. World.
struct Plane {
  Vec3 normal{0, 0, 1};  ///< Unit, out of the half that is filled.
  double offset_m = 0;
  double friction = 0.5;  ///< Coulomb's coefficient, sticking and sliding.
  /// Resistance to rolling and to spinning on the spot: its torque over the force that presses, m. Wood on wood 0.5 mm.
  /// With none, a round body, which is a polyhedron here, rocks on its facets for long.
  double rolling_m = 2e-4;
};

/// Which motions a body has. The surface's friction with the stylus is not meant here.
enum class Freedom : std::uint8_t {
  kFree,    ///< All six.
  kHinge,   ///< Turns about an axis that stands still in the world.
  kSlider,  ///< Moves along such an axis.
};

/// The axis of a hinge or slider, in the object's frame, and how far from the rest pose it lets the body.
struct Joint {
  Vec3 anchor_m{0};                                          ///< A point on a hinge's axis.
  Vec3 axis{0, 0, 1};                                        ///< Unit.
  double lowest = -std::numeric_limits<double>::infinity();  ///< rad or m, not above 0.
  double highest = std::numeric_limits<double>::infinity();  ///< Not below 0.
};

/// Pulls the body back to its rest pose: at the centre of mass, and about it (a hinge: about the axis; a slider: along it).
/// The integration holds stiffnesses up to mass / period^2 (moment / period^2); a stiffer spring acts as if it had that.
struct PoseSpring {
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;
  double stiffness_Nm_per_rad = 0;
  double damping_Nms_per_rad = 0;
};

/// How many planes one body may rest on, and at how many points on each. Three points bear a body; a fourth keeps boxes
/// from rocking between two choices of three.
inline constexpr std::size_t kMaxPlanes = 4;
inline constexpr std::size_t kPointsOnPlane = 4;

/// What a body is, beside its shape; fixed from edit to edit, made off the servo's thread.
struct RigidBody {
  MassProperties mass;
  Vec3 gravity_m_per_s2{0, 0, -9.81};
  double linearDamping_per_s = 0;   ///< Rate at which momentum goes; 1 halves it in 0.7 s.
  double angularDamping_per_s = 0;  ///< Of angular momentum.
  PoseSpring spring;

  Freedom freedom = Freedom::kFree;
  Joint joint;  ///< Unless free.

  std::array<Plane, kMaxPlanes> planes;  ///< Stop free bodies only; what hinges and slides has its limits.
  std::size_t planeCount = 0;
  std::vector<Vec3> support;  ///< supportPoints() in the frame of the principal axes, from the centre of mass.
  double radius_m = 0;        ///< Of the sphere round the centre of mass that holds all of `support`.

  /// Puts the support points of an object (object frame) into the frame of the principal axes; mass comes first.
  void setSupport(const std::vector<Vec3>& points);
};

/// Where a body touches a plane, and how hard: the next tick's first guess.
struct PlanePoint {
  std::uint32_t plane = 0;
  std::uint32_t point = 0;  ///< Index into RigidBody::support.
  Vec3 impulse_Ns{0};       ///< On the body, world.

  HAPTICS_FIELDS(self.plane, self.point, self.impulse_Ns);
};

/// What a tick leaves to the next. Momenta instead of velocities: what no torque acts on then keeps its angular momentum
/// to the last bit, and the gyroscopic torque of an asymmetric body needs no term of its own.
struct RigidState {
  Pose rest;  ///< Of the object, world: as the scene has it. Springs pull there; a joint's axis is where it puts it.

  // A free body; world frame.
  Vec3 centre_m{0};
  Quat axes{1, 0, 0, 0};  ///< Principal axes to world.
  Vec3 momentum_Ns{0};
  Vec3 angularMomentum_Nms{0};  ///< About the centre of mass.
  Sequence<PlanePoint, kMaxPlanes * kPointsOnPlane> touching;
  Vec3 rolling_Nms{0};  ///< What resistance to rolling gave it in the last tick.

  // A hinge's angle (rad) or a slider's offset (m) from the rest pose.
  double coordinate = 0;
  double rate_per_s = 0;

  Pose still;          ///< The pose of the object near which it has been for still_s.
  double still_s = 0;  ///< Seconds in which it has hardly moved.
  Word<BodyCondition> condition = BodyCondition::kAwake;

  HAPTICS_FIELDS(self.rest, self.centre_m, self.axes, self.momentum_Ns, self.angularMomentum_Nms, self.touching,
                 self.rolling_Nms, self.coordinate, self.rate_per_s, self.still, self.still_s, self.condition);
};
static_assert(std::is_trivially_copyable_v<RigidState>, "copied to replay and to compare runs");

/// The stylus' force on a body; world.
struct Push {
  Vec3 force_N{0};
  Vec3 place_m{0};
  Vec3 torque_Nm{0};  ///< Beside that of the force at its place.

  [[nodiscard]] bool any() const noexcept { return force_N != Vec3(0) || torque_Nm != Vec3(0); }
};

/// m/s and rad/s, world; linear is that of the centre of mass.
struct RigidVelocity {
  Vec3 linear{0};
  Vec3 angular{0};
};

/// Bodies are stopped this far from the world's origin, metres: many times any device's workspace. Larger lets them fall
/// for longer, and lose digits.
inline constexpr double kWorldRadius_m = 10;

/// At rest at an object's pose.
[[nodiscard]] RigidState restingAt(const RigidBody& body, const Pose& pose) noexcept;
/// The object's pose.
[[nodiscard]] Pose poseOf(const RigidBody& body, const RigidState& state) noexcept;
[[nodiscard]] RigidVelocity velocityOf(const RigidBody& body, const RigidState& state) noexcept;
/// Kinetic and potential, of gravity and spring, J; gravity's part is 0 at the world's origin.
[[nodiscard]] double energyOf(const RigidBody& body, const RigidState& state) noexcept;

/// About the world's axes of a body whose principal axes stand so.
[[nodiscard]] inline Vec3 angularVelocity(const MassProperties& mass, Quat axes, Vec3 angularMomentum_Nms) noexcept {
  return axes * ((glm::conjugate(axes) * angularMomentum_Nms) / mass.moments);
}

}  // namespace haptics
