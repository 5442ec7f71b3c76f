#include "common/wire/snapshot.h"

#include <utility>

#include "common/wire/convert.h"

namespace haptics {

void sendSnapshot(const SceneVersion& version, std::size_t chunk_bytes,
                  const std::function<void(v1::Envelope&)>& send) {
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
    if (part->object_size() > 0 && bytes + more > chunk_bytes) {
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

}  // namespace haptics
