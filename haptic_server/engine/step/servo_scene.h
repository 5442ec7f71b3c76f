#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "common/deform/soft_tissue.h"
#include "common/maths/vec.h"
#include "common/telemetry/motion_state.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/effects/effect_field.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/motion/rigid_body.h"
#include "haptic_server/engine/step/shape_memory.h"
#include "haptic_server/engine/surface/surface_detail.h"
#include "haptic_server/engine/tool/tool_shell.h"

namespace haptics {

struct ExplorationPlan;

/// Which of the dents that the servo numbers an object's surface holds: the builder bakes in what stays.
struct BakedDents {
  std::uint64_t shape = 0;         ///< Another one where the shape at rest was edited: dents in the old one are gone.
  std::uint64_t upTo = 0;          ///< The surface holds the dents up to this number; they end with the adoption.
  std::uint64_t releasedUpTo = 0;  ///< Those up to this one that it does not hold may not stay: they go back.
  bool operator==(const BakedDents&) const = default;
};

/// KinematicPose::first_s of a client: of the rate that most have. Shorter is felt as a blow by a hand that presses, longer is late.
inline constexpr double kFirstSample_s = 1.0 / 60;

/// The newest sample of a client that drives an object: where it goes from where it is, as a motion and not as an edit.
struct KinematicPose {
  std::uint64_t number = 0;  ///< Another one of each sample; 0: none since the scene last set its pose.
  Pose pose;
  double first_s = 0;  ///< Least time to the first sample of a stream; 0: of a loop that has one in every tick.
  bool operator==(const KinematicPose&) const = default;
};

/// The same of a client that moves an object's vertices.
struct KinematicShape {
  std::uint64_t number = 0;  ///< Of the newest sample: one more than that of the one before; 0: there is none.
  std::uint64_t first = 0;   ///< At most that of the first sample since the scene last set the shape.
  ShapeSamples samples;
  double way_m = 0;    ///< From the sample before the newest to that: of the vertex that goes farthest.
  double first_s = 0;  ///< As KinematicPose's.
  /// Of each hand that is there; the same ones in each scene as long as there are samples.
  std::array<std::shared_ptr<ShapeMemory>, 2> memory;
};

/// What the servo needs of one object. Aligned so that a tick finds one by a shift of its index.
struct alignas(64) ServoObject {
  std::uint64_t id = 0;
  std::shared_ptr<const CollisionMesh> surface;
  Pose pose;
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;
  /// Removed from the scene, but still here while the contact on it fades. Cannot be touched anew.
  bool pendingRemoval = false;
  /// What its surface feels like beyond its shape; null for nothing. The same pointer from scene to scene as long as it
  /// is not edited.
  std::shared_ptr<const SurfaceDetail> detail = nullptr;
  /// What moves it; null for nothing: it stays where the scene has it. The same pointer likewise.
  std::shared_ptr<const RigidBody> motion = nullptr;
  /// Where it meets others; null: they pass through it. The same pointer likewise.
  std::shared_ptr<const CollisionPoints> collision = nullptr;
  /// The hand holds it, one of all that have one; null: it lies in the scene. The same pointer likewise.
  std::shared_ptr<const Tool> tool = nullptr;
  /// Of the spring that turns the tool, or the body that the hand holds, to where the device is turned; of what moves too
  /// above 0.
  double torsion_Nm_per_rad = 0;
  /// Of the spring that opens the tool's jaws as far as the gripper; above 0 where it has some.
  double grip_Nm_per_rad = 0;
  /// Its sharp points at the tool's spacing, where the scene has a tool; null for none. The same pointer likewise.
  std::shared_ptr<const std::vector<Vec3>> sharp = nullptr;
  /// Revision that last set its pose. What moves or was driven starts anew from there also when the pose is the same.
  std::uint64_t poseRevision = 0;
  /// What it yields like; null for a rigid one. The same pointer likewise.
  std::shared_ptr<const SoftTissue> tissue = nullptr;
  BakedDents baked = {};
  /// Largest stiffness factor of the detail, where it has one: the device would be unstable above it.
  double highestFactor = std::numeric_limits<double>::infinity();
  double graspDamping_Ns_per_m = 0;  ///< Of what moves, as torsion_Nm_per_rad.
};

struct ServoEffect {
  std::size_t body = 0;                      ///< Index of the object that carries it.
  std::uint64_t number = 0;                  ///< Among the object's.
  std::shared_ptr<const EffectField> field;  ///< The same pointer from scene to scene as long as it is not edited.
};

/// An immutable scene, built off the servo thread, adopted by it as one pointer at a tick's start.
struct ServoScene {
  /// Counts the scenes that are made for one servo, from 1: a recording names them so. 0: the empty one at the start.
  std::uint64_t number = 0;
  std::uint64_t revision = 0;
  std::vector<ServoObject> objects;      ///< At most kMaxServoObjects, in order of id.
  std::vector<KinematicPose> kinematic;  ///< Of each object, which has no motion where it is driven; empty: of none.
  std::vector<KinematicShape> shapes;    ///< Of each object; empty: of none.
  std::vector<ServoEffect> effects;      ///< At most kMaxEffects, in order of the objects.
  std::shared_ptr<const ExplorationPlan> plan;  ///< The device's; null unless a simulated hand explores.

  [[nodiscard]] bool anyDriven() const noexcept {
    return std::ranges::any_of(kinematic, [](const KinematicPose& sample) { return sample.number != 0; });
  }
  [[nodiscard]] bool anyReshaped() const noexcept {
    return std::ranges::any_of(shapes, [](const KinematicShape& sample) { return sample.number != 0; });
  }
};

/// Capacity of the per-object state in the servo; a transaction that would pass it is rejected.
inline constexpr std::size_t kMaxServoObjects = 256;

}  // namespace haptics
