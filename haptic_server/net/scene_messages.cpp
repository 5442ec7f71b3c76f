#include "haptic_server/net/scene_messages.h"

#include <cstddef>
#include <memory>
#include <utility>
#include <variant>

#include "common/wire/convert.h"
#include "common/wire/framing.h"

namespace haptics {
namespace {

/// Tag and length of an object inside SnapshotObjects, at most.
constexpr std::size_t kPerObject_bytes = 6;

}  // namespace

void sendSnapshot(const SceneVersion& version, const std::function<void(v1::Envelope&)>& send) {
  v1::Envelope envelope;
  envelope.mutable_snapshot_begin()->set_revision(version.revision());
  envelope.mutable_snapshot_begin()->set_object_count(version.objects().size());
  send(envelope);

  std::size_t bytes = 0;
  v1::SnapshotObjects* part = envelope.mutable_snapshot_objects();
  for (const auto& object : version.objects()) {
    v1::ObjectState state;
    toWire(*object, state);
    const std::size_t more = state.ByteSizeLong() + kPerObject_bytes;
    if (part->object_size() > 0 && bytes + more > kMaxChunkBytes) {
      send(envelope);
      part->clear_object();
      bytes = 0;
    }
    *part->add_object() = std::move(state);
    bytes += more;
  }
  if (part->object_size() > 0) send(envelope);

  envelope.mutable_snapshot_end()->set_revision(version.revision());
  envelope.mutable_snapshot_end()->set_root(version.root().asBytes());
  send(envelope);
}

void toWire(const EditOutcome& outcome, v1::EditReply& reply) {
  if (const auto* error = std::get_if<Error>(&outcome)) {
    reply.mutable_rejected()->set_field(error->field);
    reply.mutable_rejected()->set_reason(error->reason);
    return;
  }
  if (const auto* conflict = std::get_if<EditConflict>(&outcome)) {
    reply.mutable_conflict()->set_reason(conflict->reason);
    for (const auto& object : conflict->current) toWire(*object, *reply.mutable_conflict()->add_current());
    return;
  }
  const AcceptedEdit& edit = *std::get<std::shared_ptr<const AcceptedEdit>>(outcome);
  v1::Accepted& accepted = *reply.mutable_accepted();
  accepted.set_revision(edit.commit.revision);
  accepted.set_root(edit.commit.root.asBytes());
  for (const ObjectRecord& record : edit.commit.put) toWire(record, *accepted.add_object());
  for (const std::string& report : edit.reports) accepted.add_report(report);
}

}  // namespace haptics
