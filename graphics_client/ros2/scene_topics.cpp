#include "graphics_client/ros2/scene_topics.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <utility>

#include "graphics_client/ros2/message_parts.h"
#include "graphics_client/surface/surface_request.h"

namespace haptics {
namespace {

enum MarkerType : std::int32_t { kCube = 1, kTriangleList = 11 };  // visualization_msgs/msg/Marker
enum MarkerAction : std::int32_t { kAdd = 0, kDeleteAll = 3 };

/// Markers with what they point to. Fields that are not set are empty texts and lists.
class Markers {
 public:
  explicit Markers(std::int64_t stamp_ns) : stamp_ns_(stamp_ns) {
    ros2::Marker& all = add("", ros2::kWorld, 0);  // of an earlier scene
    all.action = kDeleteAll;
  }

  void addTriangles(const ObjectRecord& object, const std::string& frame, const TriMesh& mesh) {
    ros2::Marker& marker = add(object, frame);
    marker.type = kTriangleList;
    marker.scale = {1, 1, 1};
    std::vector<ros2::Point>& points = points_.emplace_back();
    points.reserve(3 * mesh.triangles.size());
    for (const TriangleIndices& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) points.push_back(ros2::point(Vec3(mesh.vertices[corner])));
    }
    marker.points = ros2::sequenceOf<dds_sequence_geometry_msgs_msg_dds__Point_>(points);
  }

  void addBox(const ObjectRecord& object, const std::string& frame, const TriMesh& mesh) {
    ros2::Marker& marker = add(object, frame);
    marker.type = kCube;
    Vec3 least(std::numeric_limits<double>::max()), most(-least);
    for (const Vec3f& vertex : mesh.vertices) {
      least = glm::min(least, Vec3(vertex));
      most = glm::max(most, Vec3(vertex));
    }
    marker.pose.position = ros2::point(0.5 * (least + most));
    marker.scale = ros2::vector3(most - least);
  }

  void writeTo(dds::Writer<ros2::MarkerArray>& writer) {
    writer.write({ros2::sequenceOf<dds_sequence_visualization_msgs_msg_dds__Marker_>(markers_)});
    writer.flush();
  }

 private:
  ros2::Marker& add(const ObjectRecord& object, const std::string& frame) {
    texts_.push_back(object.name);
    const std::string& name = texts_.back();
    texts_.push_back(frame);
    // ROS 2's numbers are signed and of 32 bits; the name tells them apart.
    ros2::Marker& marker = add(name.c_str(), texts_.back().c_str(), static_cast<std::int32_t>(object.id & 0x7fffffff));
    const Color& color = object.material.color;
    marker.color = {color.red, color.green, color.blue, 1};
    return marker;
  }

  ros2::Marker& add(const char* name, const char* frame, std::int32_t id) {
    char* const empty = ros2::text("");
    ros2::Marker& marker = markers_.emplace_back();
    marker = {};
    marker.header = ros2::header(stamp_ns_, frame);
    marker.ns = ros2::text(name);
    marker.id = id;
    marker.action = kAdd;
    marker.pose.orientation = {0, 0, 0, 1};
    marker.frame_locked = true;
    marker.texture_resource = marker.text = marker.mesh_resource = empty;
    marker.texture.header = ros2::header(0, "");
    marker.texture.format = empty;
    marker.mesh_file.filename = empty;
    return marker;
  }

  std::int64_t stamp_ns_;
  std::vector<ros2::Marker> markers_;
  std::deque<std::string> texts_;
  std::deque<std::vector<ros2::Point>> points_;
};

class Frames {
 public:
  explicit Frames(std::int64_t stamp_ns) : stamp_ns_(stamp_ns) {}

  void add(const std::string& name, const Pose& pose) {
    names_.push_back(name);
    transforms_.push_back({ros2::header(stamp_ns_),
                           ros2::text(names_.back()),
                           {ros2::vector3(pose.position), ros2::quaternion(pose.rotation)}});
  }
  void writeTo(dds::Writer<ros2::TFMessage>& writer) {
    writer.write({ros2::sequenceOf<dds_sequence_geometry_msgs_msg_dds__TransformStamped_>(transforms_)});
    writer.flush();
  }

 private:
  std::int64_t stamp_ns_;
  std::deque<std::string> names_;
  std::vector<ros2::TransformStamped> transforms_;
};

}  // namespace

// The depths are those of ROS 2's own writers of these topics.
SceneTopics::SceneTopics(const dds::Participant& participant, const std::string& name)
    : prefix_(name.substr(1) + "/"),
      markers_(participant, name + "/scene", {.depth = 1, .transientLocal = true}),
      moving_(participant, dds::TopicName("/tf"), {.depth = 100}),
      still_(participant, dds::TopicName("/tf_static"), {.depth = 1, .transientLocal = true}) {}

void SceneTopics::update(const MirrorView& view, std::int64_t stamp_ns, std::uint64_t now_ns) {
  std::set<ObjectId> moving;
  for (const auto& [object, body] : view.bodies) moving.insert(object);
  const bool sceneChanged = view.scene != scene_;
  if (sceneChanged || moving != movingObjects_) {
    movingObjects_ = std::move(moving);
    writeStill(view, stamp_ns);
  }
  const std::uint32_t readers = markers_.readersSoFar();
  if (readers != readers_) againAt_ns_ = now_ns + kLateReader_ns;
  readers_ = readers;
  const bool again = againAt_ns_ != 0 && now_ns >= againAt_ns_;
  if (sceneChanged || view.assetBytes != assetBytes_ || again) {
    scene_ = view.scene;
    assetBytes_ = view.assetBytes;
    if (again) againAt_ns_ = 0;
    writeMarkers(view, stamp_ns);
  }
  if (now_ns >= nextFrames_ns_) {
    nextFrames_ns_ = std::max(nextFrames_ns_ + kFrames_ns, now_ns);  // ticks come together: it is called some ms late
    writeFrames(view, stamp_ns);
  }
}

void SceneTopics::writeMarkers(const MirrorView& view, std::int64_t stamp_ns) {
  Markers markers(stamp_ns);
  std::size_t triangles = 0;
  boxes_ = 0;
  for (const SceneVersion::Object& object : view.scene->objects()) {
    const auto request = surfaceRequest(*object, view, kMaxTriangles);
    if (!request) continue;  // its mesh is on its way
    const auto shape = shapeAtRest(*request);
    const std::string frame = prefix_ + object->name;
    const std::size_t count = shape->triangles.size();
    if (count <= kMaxTriangles && triangles + count <= kMaxTrianglesInAll) {
      triangles += count;
      markers.addTriangles(*object, frame, *shape);
    } else {
      ++boxes_;
      markers.addBox(*object, frame, *shape);
    }
  }
  markers.writeTo(markers_);
}

void SceneTopics::writeFrames(const MirrorView& view, std::int64_t stamp_ns) {
  Frames frames(stamp_ns);
  for (std::size_t hand = 0; hand < 2; ++hand) {
    const TelemetrySample* felt = view.felt(hand);
    if (felt == nullptr) continue;
    const std::string of = prefix_ + (hand == 0 ? "" : "second/");
    const Quat turned = hand == 0 && view.tool ? view.tool->deviceRotation : Quat(1, 0, 0, 0);
    frames.add(of + "hip", {turned, felt->hip});
    frames.add(of + "ihip", {turned, felt->ihip});
  }
  for (const auto& [id, body] : view.bodies) {
    if (const auto object = view.scene->find(id); object) frames.add(prefix_ + object->name, body.pose);
  }
  frames.writeTo(moving_);
}

void SceneTopics::writeStill(const MirrorView& view, std::int64_t stamp_ns) {
  Frames frames(stamp_ns);
  for (const SceneVersion::Object& object : view.scene->objects()) {
    if (!movingObjects_.contains(object->id)) frames.add(prefix_ + object->name, object->pose);
  }
  frames.writeTo(still_);
}

}  // namespace haptics
