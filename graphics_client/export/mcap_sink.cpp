#include "graphics_client/export/mcap_sink.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <map>
#include <set>
#include <string>

#include "common/maths/rotation.h"
#include "common/mesh/mesh_asset.h"
#include "common/wire/convert.h"
#include "foxglove.pb.h"
#include "graphics_client/export/mcap_file.h"
#include "haptics/v1/envelope.pb.h"
#include "haptics/v1/recording.pb.h"

namespace haptics {
namespace {

constexpr double kShown_Hz = 60;
constexpr double kMetresPerNewton = 0.01;  // of the arrow, as the viewer draws it
constexpr double kBall_m = 0.003;
constexpr std::uint64_t kSecond_ns = 1'000'000'000;

void addFile(const google::protobuf::FileDescriptor& file, std::set<std::string>& known,
             google::protobuf::FileDescriptorSet& set) {
  if (!known.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) addFile(*file.dependency(i), known, set);
  file.CopyTo(set.add_file());
}

/// What a reader needs to decode the message: its file and all that this one imports.
template <class Message>
[[nodiscard]] std::string schemaOf() {
  google::protobuf::FileDescriptorSet set;
  std::set<std::string> known;
  addFile(*Message::descriptor()->file(), known, set);
  return set.SerializeAsString();
}

void put(Vec3 v, foxglove::Vector3& to) {
  to.set_x(v.x);
  to.set_y(v.y);
  to.set_z(v.z);
}

void put(const Quat& q, foxglove::Quaternion& to) {
  to.set_x(q.x);
  to.set_y(q.y);
  to.set_z(q.z);
  to.set_w(q.w);
}

void put(Vec3 rgb, foxglove::Color& to) {
  to.set_r(rgb.x);
  to.set_g(rgb.y);
  to.set_b(rgb.z);
  to.set_a(1);
}

template <class Message>
void putTime(std::uint64_t time_ns, Message& message) {
  message.mutable_timestamp()->set_seconds(static_cast<std::int64_t>(time_ns / kSecond_ns));
  message.mutable_timestamp()->set_nanos(static_cast<std::int32_t>(time_ns % kSecond_ns));
}

[[nodiscard]] std::string frameOf(std::uint64_t object) { return "object " + std::to_string(object); }

/// That turns x to a direction.
[[nodiscard]] Quat alongX(Vec3 direction) {
  const Vec3 from(1, 0, 0), to = glm::normalize(direction);
  const double cosine = glm::dot(from, to);
  if (cosine < -1 + 1e-12) return {0, 0, 0, 1};
  const Vec3 axis = glm::cross(from, to);
  return glm::normalize(Quat(1 + cosine, axis.x, axis.y, axis.z));
}

class McapSink final : public SessionSink {
 public:
  explicit McapSink(const SessionFacts& facts) : facts_(facts) {}

  [[nodiscard]] Result<void> open(const std::filesystem::path& file) {
    if (auto opened = file_.open(file, facts_.server); !opened) return opened;
    telemetry_ = addChannel<v1::Telemetry>("/telemetry");
    scene_ = addChannel<v1::SnapshotObjects>("/scene");
    assets_ = addChannel<v1::RecordedAsset>("/assets");
    frames_ = addChannel<foxglove::FrameTransform>("/tf");
    objects_ = addChannel<foxglove::SceneUpdate>("/objects");
    hand_ = addChannel<foxglove::SceneUpdate>("/hand");
    return {};
  }

  /// Written with the next tick, which says when.
  [[nodiscard]] Result<void> scene(std::uint64_t, const MirrorView& view) override {
    view_ = view;
    sceneIsNew_ = true;
    return {};
  }

  [[nodiscard]] Result<void> add(const SessionTick& tick) override {
    const std::uint64_t time_ns = timeOf(tick.sample);
    if (std::exchange(sceneIsNew_, false)) {
      if (auto written = addScene(time_ns); !written) return written;
    }
    telemetryMessage_.Clear();
    toWire(tick.sample, telemetryMessage_);
    if (tick.second != nullptr) toWireOfSecondHand(*tick.second, telemetryMessage_);
    for (const BodyState& body : tick.moved) {
      toWire(body, *telemetryMessage_.add_body());
      moved_[body.object] = body.pose;
    }
    if (tick.dents != nullptr) dents_ = {tick.dents->dents().begin(), tick.dents->dents().end()};
    for (const ObjectDent& dent : dents_) toWire(dent, *telemetryMessage_.add_dent());
    if (tick.tool.object != 0) toWire(tick.tool, *telemetryMessage_.mutable_tool());
    if (auto written = add(telemetry_, time_ns, telemetryMessage_); !written) return written;
    if (time_ns < nextShown_ns_) return {};
    nextShown_ns_ = time_ns + static_cast<std::uint64_t>(kSecond_ns / kShown_Hz);
    return show(tick.sample, time_ns);
  }

  [[nodiscard]] Result<void> gap(const TickGap& gap) override {
    if (gaps_.size() < kMaxGaps) gaps_ += gap.inWords() + "\n";
    return {};
  }

  [[nodiscard]] Result<void> finish(const SessionEnd& end) override {
    file_.setMetadata("session", {{"source", facts_.source},
                                  {"server", facts_.server},
                                  {"device", facts_.device},
                                  {"second_device", facts_.secondDevice},
                                  {"rate_Hz", std::to_string(facts_.rate_Hz)},
                                  {"units", "SI; right-handed world frame"},
                                  {"ticks", std::to_string(end.ticks)},
                                  {"ticks_missed_by_servo", std::to_string(end.missed)},
                                  {"ticks_lost", std::to_string(end.lost)},
                                  {"gaps", gaps_},
                                  {"note", end.note}});
    return file_.finish();
  }

 private:
  static constexpr std::size_t kMaxGaps = 1U << 20;  // bytes of their text

  SessionFacts facts_;
  McapFile file_;
  std::uint16_t telemetry_ = 0, scene_ = 0, assets_ = 0, frames_ = 0, objects_ = 0, hand_ = 0;
  MirrorView view_;
  bool sceneIsNew_ = false;
  std::set<ContentHash> written_;  // assets
  std::map<std::uint64_t, Pose> moved_;
  std::vector<ObjectDent> dents_;
  v1::Telemetry telemetryMessage_;  // reused, as the next
  std::string bytes_;
  std::optional<std::uint64_t> first_ns_;
  std::uint64_t nextShown_ns_ = 0;
  std::string gaps_;

  template <class Message>
  [[nodiscard]] std::uint16_t addChannel(std::string_view topic) {
    return file_.addChannel(topic, Message::descriptor()->full_name(), schemaOf<Message>());
  }

  [[nodiscard]] Result<void> add(std::uint16_t channel, std::uint64_t time_ns,
                                 const google::protobuf::Message& message) {
    bytes_.clear();
    message.AppendToString(&bytes_);
    return file_.add(channel, time_ns, bytes_);
  }

  [[nodiscard]] std::uint64_t timeOf(const TelemetrySample& sample) {
    if (!first_ns_) first_ns_ = sample.time_ns;
    return static_cast<std::uint64_t>(facts_.began_unix_ns) + (sample.time_ns - *first_ns_);
  }

  [[nodiscard]] Result<void> addScene(std::uint64_t time_ns) {
    v1::SnapshotObjects records;
    foxglove::SceneUpdate update;
    auto& all = *update.add_deletions();
    putTime(time_ns, all);
    all.set_type(foxglove::SceneEntityDeletion::ALL);
    for (const auto& object : view_.scene->objects()) {
      toWire(*object, *records.add_object());
      const auto mesh = view_.meshes.find(object->mesh);
      if (mesh == view_.meshes.end()) continue;
      if (auto written = addAsset(time_ns, object->mesh, *mesh->second); !written) return written;
      addEntity(time_ns, *object, *mesh->second, *update.add_entities());
    }
    if (auto written = add(scene_, time_ns, records); !written) return written;
    nextShown_ns_ = 0;
    return add(objects_, time_ns, update);
  }

  [[nodiscard]] Result<void> addAsset(std::uint64_t time_ns, const ContentHash& hash, const TriMesh& mesh) {
    if (!written_.insert(hash).second) return {};
    v1::RecordedAsset asset;
    asset.set_kind(v1::ASSET_KIND_MESH);
    asset.set_hash(hash.asBytes());
    asset.set_data(encodeMesh(mesh));
    return add(assets_, time_ns, asset);
  }

  static void addEntity(std::uint64_t time_ns, const ObjectRecord& object, const TriMesh& mesh,
                        foxglove::SceneEntity& entity) {
    putTime(time_ns, entity);
    entity.set_frame_id(frameOf(object.id));
    entity.set_id(object.name);
    entity.set_frame_locked(true);
    auto& list = *entity.add_triangles();
    list.mutable_pose()->mutable_orientation()->set_w(1);
    for (const Vec3f& vertex : mesh.vertices) {
      auto& point = *list.add_points();
      point.set_x(vertex.x);
      point.set_y(vertex.y);
      point.set_z(vertex.z);
    }
    for (const TriangleIndices& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) list.add_indices(corner);
    }
    const Color& color = object.material.color;
    put(Vec3(color.red, color.green, color.blue), *list.mutable_color());
  }

  [[nodiscard]] Result<void> show(const TelemetrySample& sample, std::uint64_t time_ns) {
    for (const auto& object : view_.scene->objects()) {
      const auto moved = moved_.find(object->id);
      const Pose& pose = object->motion && moved != moved_.end() ? moved->second : object->pose;
      foxglove::FrameTransform transform;
      putTime(time_ns, transform);
      transform.set_parent_frame_id("world");
      transform.set_child_frame_id(frameOf(object->id));
      put(pose.position, *transform.mutable_translation());
      put(pose.rotation, *transform.mutable_rotation());
      if (auto written = add(frames_, time_ns, transform); !written) return written;
    }
    foxglove::SceneUpdate update;
    auto& entity = *update.add_entities();
    putTime(time_ns, entity);
    entity.set_frame_id("world");
    entity.set_id("hand");
    addBall(sample.hip, {0.9, 0.1, 0.1}, entity);
    addBall(sample.ihip, {0.1, 0.3, 0.9}, entity);
    if (sample.force.written != Vec3(0)) addArrow(sample.ihip, sample.force.written, entity);
    return add(hand_, time_ns, update);
  }

  static void addBall(Vec3 at, Vec3 color, foxglove::SceneEntity& entity) {
    auto& ball = *entity.add_spheres();
    put(at, *ball.mutable_pose()->mutable_position());
    ball.mutable_pose()->mutable_orientation()->set_w(1);
    put(Vec3(kBall_m), *ball.mutable_size());
    put(color, *ball.mutable_color());
  }

  static void addArrow(Vec3 at, Vec3 force_N, foxglove::SceneEntity& entity) {
    auto& arrow = *entity.add_arrows();
    put(at, *arrow.mutable_pose()->mutable_position());
    put(alongX(force_N), *arrow.mutable_pose()->mutable_orientation());
    const double length_m = kMetresPerNewton * glm::length(force_N);
    arrow.set_shaft_length(0.8 * length_m);
    arrow.set_head_length(0.2 * length_m);
    arrow.set_shaft_diameter(kBall_m / 3);
    arrow.set_head_diameter(kBall_m);
    put({1, 0.6, 0}, *arrow.mutable_color());
  }
};

}  // namespace

Result<std::unique_ptr<SessionSink>> makeMcapSink(const std::filesystem::path& file, const SessionFacts& facts) {
  auto sink = std::make_unique<McapSink>(facts);
  if (auto opened = sink->open(file); !opened) return tl::unexpected(std::move(opened).error());
  return sink;
}

}  // namespace haptics
