#include "graphics_client/audience/stored_session.h"

#include <string>
#include <utility>

#include "common/wire/convert.h"
#include "graphics_client/audience/published_messages.h"
#include "graphics_client/mirror/client_limits.h"

namespace haptics {
namespace {

Result<void> checkRoot(const SceneVersion& scene, const std::string& said, const char* field) {
  if (scene.root().asBytes() == said) return {};
  return refused(field, "differs from the root of revision " + std::to_string(scene.revision()) + " as it was read");
}

}  // namespace

Result<void> StoredSessionReader::take(const StoredMessage& message) {
  lastSequence_ = message.sequence;
  if (message.subject == subjects_.snapshot) {
    const auto part = readSnapshotPart(message.bytes);
    return part ? take(*part) : tl::unexpected<Error>(part.error());
  }
  if (message.subject == subjects_.commit) {
    const auto published = readPublishedCommit(message.bytes);
    return published ? take(*published) : tl::unexpected<Error>(published.error());
  }
  return {};
}

Result<void> StoredSessionReader::take(const v1::SnapshotPart& part) {
  if (part.has_begin()) {
    if (part.begin().object_count() > kMaxHeldObjects) {
      return refused("snapshot_part.begin.object_count", "is more than " + std::to_string(kMaxHeldObjects));
    }
    assembly_ = Assembly{part.epoch(), part.begin(), {}};
    return {};
  }
  if (!assembly_ || assembly_->epoch != part.epoch()) return refused("snapshot_part", "has no beginning");
  if (part.has_end()) return complete(part.end());
  for (const v1::ObjectState& state : part.objects().object()) {
    auto record = fromWire(state);
    if (!record) return tl::unexpected(std::move(record).error().within("snapshot_part.objects "));
    if (assembly_->objects.size() == assembly_->begin.object_count()) {
      return refused("snapshot_part.objects", "are more than the beginning says");
    }
    assembly_->objects.push_back(*std::move(record));
  }
  return {};
}

Result<void> StoredSessionReader::complete(const v1::SnapshotEnd& end) {
  Assembly whole = *std::exchange(assembly_, std::nullopt);
  if (end.revision() != whole.begin.revision() || whole.objects.size() != whole.begin.object_count()) {
    return refused("snapshot_part.end", "is not of the snapshot that was begun");
  }
  auto scene = SceneVersion::fromSnapshot(end.revision(), std::move(whole.objects));
  if (!scene) return tl::unexpected(std::move(scene).error());
  if (auto equal = checkRoot(*scene, end.root(), "snapshot_part.end.root"); !equal) return equal;
  scene_ = *std::move(scene);
  epoch_ = whole.epoch;
  return {};
}

Result<void> StoredSessionReader::take(const v1::PublishedCommit& published) {
  if (!scene_ || published.epoch() != epoch_) return refused("published_commit", "follows no snapshot of its epoch");
  const auto commit = fromWire(published.commit());
  if (!commit) return tl::unexpected<Error>(commit.error());
  if (commit->revision <= scene_->revision()) return {};
  if (auto equal = checkRoot(*scene_, commit->prevRoot.asBytes(), "published_commit.prev_root"); !equal) return equal;
  auto next = scene_->apply(*commit);
  if (!next) return tl::unexpected(std::move(next).error());
  if (next->objects().size() > kMaxHeldObjects) return refused("published_commit.put", "leads to too many objects");
  if (auto equal = checkRoot(*next, commit->root.asBytes(), "published_commit.root"); !equal) return equal;
  scene_ = *std::move(next);
  return {};
}

Result<StoredSession> StoredSessionReader::finish() && {
  if (!scene_) return refused("haptics stream", "has no whole snapshot");
  if (epoch_ != latest_.welcome().epoch()) return refused("haptics stream", "has changed while it was read");
  StoredSession session{*latest_.mutable_welcome(), *std::move(scene_), latest_.sequence(), lastSequence_};
  return session;
}

Result<std::optional<StoredSession>> readStoredSession(NatsConnection& connection, const SessionSubjects& subjects,
                                                       const std::stop_token& stop) {
  std::optional<StoredMessage> last;
  bool isAsked = false;
  auto read = connection.readStored(
      [&]() -> std::optional<StoredQuery> {
        if (std::exchange(isAsked, true)) return std::nullopt;
        return StoredQuery{.stream = subjects.sceneStream, .subject = subjects.latest};
      },
      [&](std::optional<StoredMessage> message) {
        last = std::move(message);
        return false;
      },
      stop);
  if (!read) return tl::unexpected(std::move(read).error());
  if (!last) return std::optional<StoredSession>();
  auto latest = readLatestSnapshot(last->bytes);
  if (!latest) return tl::unexpected(std::move(latest).error());

  std::uint64_t sequence = latest->sequence();
  StoredSessionReader reader(subjects, *std::move(latest));
  Result<void> taken;
  read = connection.readStored([&] { return StoredQuery{.stream = subjects.sceneStream, .sequence = sequence++}; },
                               [&](const std::optional<StoredMessage>& message) {
                                 if (!message) return false;
                                 taken = reader.take(*message);
                                 return taken.has_value();
                               },
                               stop);
  if (!read) return tl::unexpected(std::move(read).error());
  if (!taken) return tl::unexpected(std::move(taken).error());
  auto session = std::move(reader).finish();
  if (!session) return tl::unexpected(std::move(session).error());
  return std::optional(*std::move(session));
}

}  // namespace haptics
