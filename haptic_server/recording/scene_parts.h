#pragma once

#include <functional>
#include <unordered_set>
#include <vector>

#include "haptic_server/scene/servo_scene_builder.h"
#include "haptics/v1/recording.pb.h"

namespace haptics {

/// A scene that the servo was given, as a recording keeps it.
struct SceneSource {
  std::uint64_t number = 0;  ///< ServoScene::number.
  std::uint64_t revision = 0;
  std::vector<ServoObjectSource> objects;  ///< In order of id.
};

/// Tells one scene after another as parts of a recording: assets that are new, then what differs from the scene before.
class SceneParts {
 public:
  using Put = std::function<void(const v1::RecordingPart&)>;
  /// The scene that follows the one before.
  void add(const SceneSource& scene, const Put& put);

 private:
  void addAssets(const ServoObjectSource& object, const Put& put);

  std::unordered_set<ContentHash> assets_;
  std::vector<ServoObjectSource> before_;  // of the last scene added
};

}  // namespace haptics
