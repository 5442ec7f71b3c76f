#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/maths/vec.h"

// How an object moves, as both databases hold it. SI units, radians; object frame but for gravity and planes.
namespace haptics {

/// Inertia of a body whose mesh does not define it, or whose mass is not spread evenly.
struct GivenInertia {
  Vec3 centre_m{0};  ///< Of mass.
  Vec3 moments{0};   ///< xx, yy, zz about the centre, kg m^2.
  Vec3 products{0};  ///< yz, zx, xy: off the diagonal, as they stand in the tensor.
  bool operator==(const GivenInertia&) const = default;
};

/// Back to the scene's pose.
struct SpringProperties {
  double stiffness_N_per_m = 0, damping_Ns_per_m = 0;
  double stiffness_Nm_per_rad = 0, damping_Nms_per_rad = 0;
  bool operator==(const SpringProperties&) const = default;
};

struct JointProperties {
  enum class Kind : std::uint8_t { kHinge = 1, kSlider = 2 };
  Kind kind = Kind::kHinge;
  Vec3 anchor_m{0};
  Vec3 axis{0, 0, 1};  ///< Unit.
  double lowest = 0;   ///< rad or m, from the scene's pose.
  double highest = 0;
  bool operator==(const JointProperties&) const = default;
};

struct PlaneProperties {
  Vec3 normal{0, 0, 1};  ///< Unit, world.
  double offset_m = 0;
  double friction = 0.5;
  double rolling_m = 2e-4;
  bool operator==(const PlaneProperties&) const = default;
};

/// Where an object meets others.
struct CollisionProperties {
  double friction = 0.5;
  double rolling_m = 2e-4;
  bool operator==(const CollisionProperties&) const = default;
};

/// A tool's two halves, closed as its mesh is, that open with the device's gripper.
struct JawProperties {
  Vec3 hinge_m{0};      ///< On the axis.
  Vec3 axis{0, 1, 0};   ///< Unit.
  Vec3 reach{1, 0, 0};  ///< Unit, at a right angle to the axis: the jaws are on both sides of the plane along both.
  double grip_Nm_per_rad = 0.5;  ///< Opens them as far as the gripper.
  bool operator==(const JawProperties&) const = default;
};

/// An object that the hand holds in place of a point. Its pose is where the device and its rotation have it.
struct ToolProperties {
  double spacing_m = 0;           ///< Of the points of its surface that touch.
  double torsion_Nm_per_rad = 1;  ///< Turns it to where the device is turned; its material's stiffness moves it.
  std::optional<JawProperties> jaws = std::nullopt;  ///< Default: it is rigid.
  bool operator==(const ToolProperties&) const = default;
};

struct MotionProperties {
  double mass_kg = 0;
  std::optional<GivenInertia> inertia = std::nullopt;  ///< Default: of the closed mesh, evenly filled.
  Vec3 gravity_m_per_s2{0, 0, -9.81};
  double linearDamping_per_s = 0, angularDamping_per_s = 0;
  SpringProperties spring = {};
  std::optional<JointProperties> joint = std::nullopt;  ///< Default: free.
  std::vector<PlaneProperties> planes = {};
  bool fixed = false;  ///< Stays where the scene has it; nothing of the above counts.
  std::optional<CollisionProperties> collision = std::nullopt;  ///< Default: others pass through it.
  std::optional<ToolProperties> tool = std::nullopt;            ///< Held; nothing of the above counts.
  bool operator==(const MotionProperties&) const = default;
};

/// Where the jaw is that a place of the closed ones is on, when they are open so far. Object frame.
[[nodiscard]] Pose jawPose(const JawProperties& jaws, Vec3 place, double opening_rad) noexcept;

/// All fields in declaration order, counts before lists, what is not there as 0.
void addTo(Hasher& hasher, const MotionProperties& properties);

}  // namespace haptics
