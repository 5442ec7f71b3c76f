#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "haptic_server/force/spring_damper.h"
#include "haptic_server/scene/sequencer.h"
#include "haptic_server/scene/surface_warnings.h"
#include "haptic_server/step/servo_scene.h"

namespace haptics {

/// A removed object stays in the servo's scene for this long, so that a contact on it fades instead of snapping off:
/// at RateLimitedStiffness::kRate_N_per_s 15 N do.
inline constexpr std::uint64_t kRemovalFade_ns = 500'000'000;

/// What one object of a servo scene is made of.
struct ServoObjectSource {
  SceneVersion::Object record;
  ObjectAssets assets;
  std::uint64_t poseRevision = 0;  ///< ServoObject::poseRevision.
  bool pendingRemoval = false;
};

/// Makes the servo's scenes from the sequencer's revisions. Remembers which objects are leaving, and what the surfaces of
/// those that stay were made of. Builder thread.
class ServoSceneBuilder {
 public:
  /// The exploration for a scene whose objects are complete, those that move at the poses where they rest.
  using MakePlan = std::function<std::shared_ptr<const ExplorationPlan>(const ServoScene&)>;

  /// @param device  Surfaces stiffer than it bears are made with what it bears; its servo's period decides how stiff light
  /// bodies can be felt (stableStiffnessShare()).
  explicit ServoSceneBuilder(MakePlan makePlan, const DeviceLimits& device = {});

  /// The surface holds an object's dents up to this number once the object has this residue.
  void setBakedDents(ObjectId object, const std::optional<ContentHash>& residue, std::uint64_t upTo);
  /// They may not stay.
  void releaseDents(ObjectId object, std::uint64_t upTo) { dentStates_[object].releasedUpTo = upTo; }

  enum class Plan { kOfTheLastScene, kOfThisOne };  ///< Planning takes milliseconds, which no edit should wait for.

  /// The sequencer's current version for the servo. Objects that were in the last one and are gone are leaving; those
  /// that have left for kRemovalFade_ns are dropped. The first scene's plan is always its own.
  [[nodiscard]] std::unique_ptr<const ServoScene> make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan);
  /// The same from these objects, in order of id, leaving ones included, and without a plan. What did not change since
  /// the last scene made is the same in memory.
  [[nodiscard]] std::unique_ptr<ServoScene> make(std::vector<ServoObjectSource> objects, std::uint64_t revision);
  /// What the last scene was made of, object by object.
  [[nodiscard]] const std::vector<ServoObjectSource>& parts() const noexcept { return parts_; }
  /// Whether the last scene's plan was made for another revision, or for bodies that were elsewhere.
  [[nodiscard]] bool planIsOld() const noexcept { return makePlan_ && (planRevision_ != revision_ || bodiesMoved_); }
  /// Where the objects that move are. When they rest somewhere else than the plan has them, it is old.
  void follow(const MotionState& motion);
  /// When make() is to be called again though nothing was edited: the time when the next object has left.
  [[nodiscard]] std::optional<std::uint64_t> nextDeparture_ns() const;

 private:
  struct PendingRemoval {
    ServoObjectSource object;
    std::uint64_t until_ns;
  };
  struct CachedObject {
    std::shared_ptr<const CollisionMesh> surface;
    SurfaceProperties properties;
    std::shared_ptr<const SurfaceDetail> detail;
    std::optional<MotionProperties> motion = std::nullopt;
    BodyParts body = {};
    std::shared_ptr<const CollisionMesh> atRest = nullptr;  ///< Of the mesh: `surface` is as the lattice has it.
    DeformationProperties deformation = {};
    std::shared_ptr<const SoftTissue> tissue = nullptr;
    BakedDents baked = {};
    std::shared_ptr<const std::vector<Vec3>> sharp = nullptr;  ///< Of the surface, at the spacing;
    double spacing_m = 0;                                      ///< none at 0.
  };
  /// An object's dents as last set.
  struct DentState {
    std::optional<ContentHash> residue;  // with which the shape is the same as before, only with dents in it
    std::uint64_t upTo = 0, releasedUpTo = 0;
  };
  MakePlan makePlan_;
  DeviceLimits device_;
  std::map<ObjectId, CachedObject> cachedObjects_;  // of the last scene made
  std::map<ObjectId, DentState> dentStates_;
  std::vector<ServoObjectSource> parts_;         // of the last scene made, in order of id
  std::vector<PendingRemoval> pendingRemovals_;  // in order of time
  std::shared_ptr<const ExplorationPlan> plan_;
  std::uint64_t number_ = 0;        // of the last scene made
  std::uint64_t revision_ = 0;      // of the last scene made
  std::uint64_t planRevision_ = 0;  // for which plan_ was made

  std::map<ObjectId, BodyState> bodies_;  // as they rested last
  bool bodiesMoved_ = false;              // since plan_ was made

  /// What the device bears of a material: at a factor of 1, and the highest factor.
  struct StableStiffness {
    Stiffness stiffness;
    double highestFactor;
  };
  [[nodiscard]] StableStiffness stableStiffness(const Material& material, const SurfaceDetail* detail) const;
  [[nodiscard]] double stableTorsion_Nm_per_rad(const ToolProperties& tool) const;
  [[nodiscard]] std::shared_ptr<const ExplorationPlan> planFor(ServoScene scene) const;
  void addPendingRemovals(std::vector<ServoObjectSource>& objects, const SceneVersion& version, std::uint64_t now_ns);

  // `before` is the object as it was in the last scene; null: it was not in it.
  void addBody(CachedObject& cached, const ObjectRecord& record, const ObjectAssets& assets,
               const CachedObject* before) const;
  CachedObject detailOf(const ObjectRecord& record, const ObjectAssets& assets, const CachedObject* before) const;
  std::shared_ptr<const CollisionMesh> shapeOf(const ObjectRecord& record, const ObjectAssets& assets,
                                               const CachedObject* before) const;
  void addSharpPoints(ServoScene& scene, std::map<ObjectId, CachedObject>& cached, double spacing_m) const;
  void addTissue(CachedObject& cached, const ObjectRecord& record, const CachedObject* before) const;
  void addBakedDents(CachedObject& cached, ObjectId object, const CachedObject* before) const;
};

}  // namespace haptics
