#pragma once

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "common/error/error.h"
#include "haptic_server/recording/recording_writer.h"
#include "haptic_server/scene/servo_scene_builder.h"
#include "haptics/v1/recording.pb.h"

namespace haptics {

/// A scene of a recording again.
struct RemadeScene {
  std::unique_ptr<const ServoScene> scene;
  SceneVersion version;                    ///< Of the objects that are not leaving.
  std::vector<ServoObjectSource> objects;  ///< What the scene is made of, object by object.
};

/// Makes the servo's scenes of a recording again. What was one in memory in the servo is one here too: assets by their
/// content, what is made of them as long as it did not change. Untrusted messages are welcome.
class RecordedScenes {
 public:
  /// The store outlives it.
  RecordedScenes(AssetStore& store, const RecordingFacts& facts)
      : store_(store),
        builder_({}, facts.limits),
        feltAsRecorded_(facts.isWithoutLimits),
        hasRoom_(static_cast<std::size_t>(facts.limits.hands) >= facts.hands()) {}

  /// Refused: data that does not have the hash, or is not of the kind.
  [[nodiscard]] Result<void> add(const v1::RecordedAsset& asset);
  /// The next scene. Refused: values that an edit could not have set, assets that are not here, a number out of turn,
  /// a root that is not that of the objects.
  [[nodiscard]] Result<RemadeScene> make(const v1::RecordedScene& message);

 private:
  AssetStore& store_;
  std::unordered_map<ContentHash, std::shared_ptr<const Asset>> assets_;
  /// What an old recording has made of an object's material.
  struct Felt {
    double stiffness_N_per_m, damping_Ns_per_m, torsion_Nm_per_rad;
  };
  ServoSceneBuilder builder_;
  bool feltAsRecorded_;
  bool hasRoom_;                            // for shapes that each hand moves
  std::map<ObjectId, Felt> felt_;           // where it is as recorded
  std::vector<ServoObjectSource> objects_;  // of the last scene made, in order of id
  std::uint64_t number_ = 0;

  [[nodiscard]] Result<std::vector<ServoObjectSource>> objectsOf(const v1::RecordedScene& message);
  [[nodiscard]] Result<DrivenShape> shapeOf(const v1::RecordedShape& message, const ObjectRecord& record,
                                            const ObjectAssets& assets) const;
  [[nodiscard]] Result<std::shared_ptr<const DrivenShape::Sample>> sampleOf(const v1::Lattice& message,
                                                                            const ObjectRecord& record,
                                                                            const ObjectAssets& assets) const;
  [[nodiscard]] Result<ServoObjectSource> objectOf(const v1::RecordedObject& message) const;
  [[nodiscard]] Result<void> takeFelt(const v1::RecordedObject& message, const ServoObjectSource& object);
};

}  // namespace haptics
