#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "haptic_server/engine/force/spring_damper.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/scene/effect_limits.h"
#include "haptic_server/scene/sequencer.h"

namespace haptics {

/// A removed object stays in the servo's scene for this long, so that a contact on it fades instead of snapping off:
/// at RateLimitedStiffness::kRate_N_per_s 15 N do.
inline constexpr std::uint64_t kRemovalFade_ns = 500'000'000;

/// Source of one object of a servo scene, beside the device's limits. A recording holds all of it.
struct ServoObjectSource {
  SceneVersion::Object record;
  ObjectAssets assets;             ///< Those that the record names; what is derived of them saves time only.
  std::uint64_t poseRevision = 0;  ///< ServoObject::poseRevision.
  bool pendingRemoval = false;
  BakedDents baked = {};         ///< ServoObject::baked.
  KinematicPose kinematic = {};  ///< As in ServoScene::kinematic.
  DrivenShape shape = {};        ///< Of an object that whyNotReshaped() does not name; stays at rest beside a tool.

  [[nodiscard]] ObjectId id() const noexcept { return record->id; }
};

/// Makes the servo's scenes from the sequencer's revisions. Remembers which objects are leaving, and what the last scene was
/// made of. Builder thread.
class ServoSceneBuilder {
 public:
  /// The exploration for a scene whose objects are complete, those that move at the poses where they rest.
  using MakePlan = std::function<std::shared_ptr<const ExplorationPlan>(const ServoScene&)>;
  /// Gets a scene and what it is made of, object by object.
  using OnMade = std::function<void(const ServoScene&, const std::vector<ServoObjectSource>&)>;

  /// @param device  Surfaces stiffer than it bears are made with what it bears; its servo's period decides how stiff light
  /// bodies can be felt (stableStiffnessShare()).
  explicit ServoSceneBuilder(MakePlan makePlan, const DeviceLimits& device = {});

  /// The surface holds an object's dents up to this number once the object has this residue.
  void setBakedDents(ObjectId object, const std::optional<ContentHash>& residue, std::uint64_t upTo);
  /// Makes the object's dents up to this number go back.
  void releaseDents(ObjectId object, std::uint64_t upTo) { dentStates_[object].releasedUpTo = upTo; }

  enum class Plan { kKeep, kReplan };  ///< Planning takes milliseconds, which no edit should wait for.

  /// The sequencer's current version for the servo. Objects that were in the last one and are gone are leaving; those
  /// that have left for kRemovalFade_ns are dropped. The first scene's plan is always its own.
  /// @param onMade  Where it throws, or making the scene does, the next one has this one's number and is made of the last one's
  ///                parts.
  [[nodiscard]] std::unique_ptr<ServoScene> make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan,
                                                 const OnMade& onMade = {});
  /// The same from these objects, in order of id, leaving ones included, and without a plan. A part is the last scene's, the
  /// same in memory, where and only where what it is made of has the same values: by that adoptScene() tells edits, and a
  /// scene made again of recorded sources is edited where the first one was.
  [[nodiscard]] std::unique_ptr<ServoScene> make(std::vector<ServoObjectSource> objects, std::uint64_t revision) {
    return keep(build(std::move(objects), revision));
  }
  /// Whether the last scene's plan was made for another revision, or for bodies that were elsewhere.
  [[nodiscard]] bool planIsOld() const noexcept { return planIsOld(revision_); }
  /// Where the objects that move are. When they rest somewhere else than the plan has them, it is old.
  void follow(const MotionState& motion);
  /// When make() is to be called again though nothing was edited: the time when the next object has left.
  [[nodiscard]] std::optional<std::uint64_t> nextDeparture_ns() const;

 private:
  struct PendingRemoval {
    ServoObjectSource object;
    std::uint64_t until_ns;
  };
  struct ObjectParts {
    std::shared_ptr<const CollisionMesh> surface;
    std::shared_ptr<const SurfaceDetail> detail;
    BodyParts body;
    std::shared_ptr<const SoftTissue> tissue;
    KinematicShape shape;
    std::vector<std::shared_ptr<const EffectField>> effects;
    std::vector<EffectShare> shares;                 ///< Of the effects.
    std::shared_ptr<const std::vector<Vec3>> sharp;  ///< Of the surface, at the spacing;
    double spacing_m = 0;                            ///< none at 0.
  };
  /// An object's dents as last set.
  struct DentState {
    std::optional<ContentHash> residue;  // with which the shape is the same as before, only with dents in it
    std::uint64_t upTo = 0, releasedUpTo = 0;
  };
  MakePlan makePlan_;
  DeviceLimits device_;
  std::map<ObjectId, ObjectParts> parts_;  // of the last scene made
  std::map<ObjectId, DentState> dentStates_;
  std::vector<ServoObjectSource> sources_;       // of the last scene made, in order of id
  std::vector<PendingRemoval> pendingRemovals_;  // in order of time
  std::shared_ptr<const ExplorationPlan> plan_;
  std::uint64_t number_ = 0;        // of the last scene made
  std::uint64_t revision_ = 0;      // of the last scene made
  std::uint64_t planRevision_ = 0;  // for which plan_ was made

  std::map<ObjectId, BodyState> bodies_;  // as they rested last
  bool bodiesMoved_ = false;              // since plan_ was made

  struct Made {
    std::unique_ptr<ServoScene> scene;
    std::map<ObjectId, ObjectParts> parts;
    std::vector<ServoObjectSource> sources;
  };
  [[nodiscard]] Made build(std::vector<ServoObjectSource> objects, std::uint64_t revision) const;
  /// It is the last scene made from now on.
  [[nodiscard]] std::unique_ptr<ServoScene> keep(Made made) noexcept;
  [[nodiscard]] bool planIsOld(std::uint64_t revision) const noexcept {
    return makePlan_ && (planRevision_ != revision || bodiesMoved_);
  }
  /// A material's stiffness within the device's limit: at a factor of 1, and the highest factor.
  struct StableStiffness {
    Stiffness stiffness;
    double highestFactor;
  };
  [[nodiscard]] StableStiffness stableStiffness(const Material& material, const SurfaceDetail* detail) const;
  [[nodiscard]] std::shared_ptr<const ExplorationPlan> planFor(ServoScene scene) const;
  [[nodiscard]] const ServoObjectSource* sourceBefore(ObjectId id) const;
  void addPendingRemovals(std::vector<ServoObjectSource>& objects, const SceneVersion& version, std::uint64_t now_ns);
  [[nodiscard]] BakedDents bakedDents(const ObjectRecord& record) const;
  [[nodiscard]] KinematicShape shapeOf(const ServoObjectSource& source, const CollisionMesh& surface,
                                       const KinematicShape& last) const;
  /// @param effects  Of all objects that stay.
  [[nodiscard]] ObjectParts partsOf(const ServoObjectSource& source, const EffectZones& effects) const;
  [[nodiscard]] std::vector<std::shared_ptr<const EffectField>> effectsOf(const ObjectRecord& record,
                                                                          const ObjectParts& parts,
                                                                          const EffectZones& all) const;
  void addSharpPoints(ServoScene& scene, std::map<ObjectId, ObjectParts>& parts, double spacing_m) const;
};

}  // namespace haptics
