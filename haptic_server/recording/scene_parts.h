#pragma once

#include <functional>
#include <unordered_set>
#include <vector>

#include "haptic_server/scene/servo_scene_builder.h"
#include "haptics/v1/recording.pb.h"

namespace haptics {

/// An object of a scene that the servo was given, as a recording keeps it: what it is made of, and what limits have made of
/// its material.
struct GivenObject {
  ServoObjectSource parts;
  double stiffness_N_per_m = 0;  ///< ServoObject's.
  double damping_Ns_per_m = 0;
  double torsion_Nm_per_rad = 0;
  BakedDents baked = {};  ///< ServoObject's.

  [[nodiscard]] ObjectId id() const noexcept { return parts.record->id; }
};

struct GivenScene {
  std::uint64_t number = 0;  ///< ServoScene::number.
  std::uint64_t revision = 0;
  std::vector<GivenObject> objects;  ///< In order of id.
};

/// \param parts  What the scene is made of, object by object.
[[nodiscard]] GivenScene givenScene(const ServoScene& scene, const std::vector<ServoObjectSource>& parts);

/// Tells one scene after another as parts of a recording: assets that are new, then what differs from the scene before.
class SceneParts {
 public:
  using Put = std::function<void(const v1::RecordingPart&)>;
  /// The scene that follows the one before.
  void add(const GivenScene& scene, const Put& put);

 private:
  void addAssets(const ServoObjectSource& object, const Put& put);

  std::unordered_set<ContentHash> assets_;
  std::vector<GivenObject> before_;  // of the last scene added
};

}  // namespace haptics
