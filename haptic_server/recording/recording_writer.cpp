#include "haptic_server/recording/recording_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/wire/convert.h"
#include "haptic_server/recording/state_image.h"

namespace haptics {
namespace {

constexpr int kPermissions = 0666;  // less the umask

[[nodiscard]] tl::unexpected<Error> failed(const std::filesystem::path& file) {
  return refused(file.string(), "the recording cannot be written: " + std::generic_category().message(errno));
}

[[nodiscard]] const GivenObject* find(const std::vector<GivenObject>& objects, ObjectId id) {
  const auto at = std::ranges::lower_bound(objects, id, {}, &GivenObject::id);
  return at == objects.end() || at->id() != id ? nullptr : &*at;
}

/// But for whether it is leaving.
[[nodiscard]] bool isSame(const GivenObject& a, const GivenObject& b) {
  return *a.parts.record == *b.parts.record && a.parts.poseRevision == b.parts.poseRevision &&
         a.stiffness_N_per_m == b.stiffness_N_per_m && a.damping_Ns_per_m == b.damping_Ns_per_m && a.taken == b.taken;
}

[[nodiscard]] std::string rootOf(const GivenScene& scene) {
  std::vector<ObjectRecord> records;
  for (const GivenObject& object : scene.objects) {
    if (!object.parts.leaving) records.push_back(*object.parts.record);
  }
  return SceneVersion::fromSnapshot(scene.revision, std::move(records)).value().root().asBytes();
}

}  // namespace

GivenScene givenScene(const ServoScene& scene, const std::vector<ServoObjectParts>& parts) {
  GivenScene given{scene.number, scene.revision, {}};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const ServoObject& object = scene.objects[i];
    given.objects.push_back({parts[i], object.stiffness_N_per_m, object.damping_Ns_per_m, object.taken});
  }
  return given;
}

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& file, const RecordingFacts& facts) {
  FileHandle handle(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kPermissions));
  if (!handle) return failed(file);
  RecordingWriter writer(file, std::move(handle));
  writer.pending_ = kRecordingHead;
  v1::RecordingPart part;
  *part.mutable_head() = toMessage(facts);
  writer.append(part);
  if (auto written = writer.flush(); !written) return tl::unexpected(written.error());
  return writer;
}

void RecordingWriter::append(const v1::RecordingPart& part) { chain_.append(pending_, part.SerializeAsString()); }

void RecordingWriter::addAssets(const ServoObjectParts& object) {
  for (const AssetName& name : object.record->assets()) {
    const auto asset = object.assets.find(name.hash);
    if (!asset || !assets_.insert(name.hash).second) continue;
    v1::RecordingPart part;
    v1::RecordedAsset& message = *part.mutable_asset();
    message.set_kind(static_cast<v1::AssetKind>(name.kind));
    message.set_hash(name.hash.asBytes());
    message.set_data(*asset->encoded);
    append(part);
  }
}

void RecordingWriter::add(const GivenScene& scene) {
  v1::RecordingPart part;
  v1::RecordedScene& message = *part.mutable_scene();
  message.set_number(scene.number);
  message.set_revision(scene.revision);
  message.set_root(rootOf(scene));
  for (const GivenObject& object : scene.objects) {
    if (object.parts.leaving) message.add_leaving(object.id());
    if (const GivenObject* before = find(before_, object.id()); before != nullptr && isSame(*before, object)) continue;
    addAssets(object.parts);
    v1::RecordedObject& put = *message.add_put();
    toWire(*object.parts.record, *put.mutable_state());
    put.set_posed_at(object.parts.poseRevision);
    put.set_stiffness_n_per_m(object.stiffness_N_per_m);
    put.set_damping_ns_per_m(object.damping_Ns_per_m);
    put.set_shape(object.taken.shape);
    put.set_dents_taken_up_to(object.taken.upTo);
    put.set_dents_loosened_up_to(object.taken.loosenedUpTo);
  }
  for (const GivenObject& object : before_) {
    if (find(scene.objects, object.id()) == nullptr) message.add_gone(object.id());
  }
  append(part);
  before_ = scene.objects;
}

void RecordingWriter::add(const Keyframe& keyframe) {
  v1::RecordingPart part;
  v1::RecordedState& message = *part.mutable_state();
  message.set_scene(keyframe.scene);
  message.set_pending(keyframe.pending);
  message.set_image(stateImage(keyframe.state));
  append(part);
}

Result<void> RecordingWriter::flush() {
  if (!ticks_.empty()) {
    v1::RecordingPart part;
    part.mutable_ticks()->set_ticks(std::exchange(ticks_, {}));
    append(part);
  }
  std::string_view left = pending_;
  while (!left.empty()) {
    const ssize_t written = ::write(handle_.descriptor(), left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      auto error = failed(file_);
      (void)::ftruncate(handle_.descriptor(), static_cast<off_t>(size_));
      return error;
    }
    left.remove_prefix(static_cast<std::size_t>(written));
  }
  size_ += pending_.size();
  pending_.clear();
  return {};
}

}  // namespace haptics
