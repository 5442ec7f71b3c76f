#pragma once

#include <string>
#include <vector>

#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "common/wire/snapshot.h"
#include "graphics_client/audience/session_subjects.h"
#include "graphics_client/audience/stored_session.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics {

/// What a relay publishes of a fake server.
class PublishedSession {
 public:
  PublishedSession() {
    server.addObject("a");
    server.addObject("b");
  }

  [[nodiscard]] v1::LatestSnapshot latest() const {
    v1::LatestSnapshot latest;
    latest.set_protocol_version(kProtocolVersion);
    latest.set_sequence(1);
    latest.mutable_welcome()->set_epoch(server.epoch);
    latest.mutable_welcome()->set_revision(server.scene.revision());
    latest.mutable_welcome()->set_root(server.scene.root().asBytes());
    latest.mutable_welcome()->set_device("simulated");
    latest.mutable_welcome()->set_datagram_cookie("secret");
    latest.mutable_welcome()->set_may_edit(true);
    return latest;
  }

  void storeSnapshot() {
    sendSnapshot(server.scene, kMaxChunkBytes, [this](const v1::Envelope& envelope) {
      v1::SnapshotPart part;
      part.set_protocol_version(kProtocolVersion);
      part.set_epoch(server.epoch);
      if (envelope.has_snapshot_begin()) *part.mutable_begin() = envelope.snapshot_begin();
      if (envelope.has_snapshot_objects()) *part.mutable_objects() = envelope.snapshot_objects();
      if (envelope.has_snapshot_end()) *part.mutable_end() = envelope.snapshot_end();
      store(subjects.snapshot, part.SerializeAsString());
    });
  }

  /// Changes the scene; what is published of it.
  [[nodiscard]] v1::PublishedCommit commit(const std::string& name) {
    v1::PublishedCommit published;
    published.set_protocol_version(kProtocolVersion);
    published.set_epoch(server.epoch);
    *published.mutable_commit() = server.addObject(name);
    return published;
  }

  void store(const std::string& subject, std::string bytes) {
    stored.push_back({stored.size() + 1, subject, std::move(bytes)});
  }

  /// As a reader makes it of all that is stored.
  [[nodiscard]] Result<StoredSession> read() const { return read(stored); }
  [[nodiscard]] Result<StoredSession> read(const std::vector<StoredMessage>& messages) const {
    StoredSessionReader reader(subjects, latest());
    for (const StoredMessage& message : messages) {
      if (auto taken = reader.take(message); !taken) return tl::unexpected(taken.error());
    }
    return std::move(reader).finish();
  }

  const SessionSubjects subjects = SessionSubjects::of("test").value();
  FakeServer server;
  std::vector<StoredMessage> stored;
};

}  // namespace haptics
