#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/ros2/dds.h"
#include "graphics_client/ros2/message_types.h"

namespace haptics {

/// Shape and place of the objects, and the places of the hands, for RViz: markers, /tf_static and /tf.
class SceneTopics {
 public:
  /// Of an object; one with more is drawn as its bounding box. RViz takes each triangle as three points of 24 bytes.
  static constexpr std::size_t kMaxTriangles = 20'000;
  static constexpr std::size_t kMaxTrianglesInAll = 200'000;
  /// Between two messages on /tf.
  static constexpr std::uint64_t kFrames_ns = 1'000'000'000 / 60;
  /// After a reader was found, until it has found us: it then gets the markers, also if it did not ask for old ones.
  static constexpr std::uint64_t kLateReader_ns = 1'000'000'000;

  /// @param name  Namespace, "/haptics". Frames are called "haptics/box".
  SceneTopics(const dds::Participant& participant, const std::string& name);

  /// To be called some hundred times a second at most; most calls do nothing.
  void update(const MirrorView& view, std::int64_t stamp_ns, std::uint64_t now_ns);
  /// Drawn as boxes, as of the last markers.
  [[nodiscard]] std::size_t boxes() const noexcept { return boxes_; }

 private:
  std::string prefix_;  // "haptics/"
  dds::Writer<ros2::MarkerArray> markers_;
  dds::Writer<ros2::TFMessage> moving_, still_;

  std::shared_ptr<const SceneVersion> scene_;
  std::size_t assetBytes_ = 0;
  std::set<ObjectId> movingObjects_;
  std::uint32_t readers_ = 0;
  std::uint64_t againAt_ns_ = 0;  // 0: markers are not written again
  std::uint64_t nextFrames_ns_ = 0;
  std::size_t boxes_ = 0;

  void writeMarkers(const MirrorView& view, std::int64_t stamp_ns);
  void writeFrames(const MirrorView& view, std::int64_t stamp_ns);
  void writeStill(const MirrorView& view, std::int64_t stamp_ns);
};

}  // namespace haptics
