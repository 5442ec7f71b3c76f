#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "graphics_client/audience/nats_connection.h"
#include "graphics_client/audience/session_subjects.h"
#include "haptics/v1/audience.pb.h"

namespace haptics {

/// A published session as its stream has it.
struct StoredSession {
  v1::Welcome welcome;                 ///< As LatestSnapshot has it.
  SceneVersion scene;                  ///< After the last commit that is stored; every root was checked.
  std::uint64_t snapshotSequence = 0;  ///< Of the snapshot that it was read from.
  std::uint64_t lastSequence = 0;      ///< That was read.
};

/// Makes a scene of a stream's messages, in their order. A snapshot that was left unfinished changes nothing.
class StoredSessionReader {
 public:
  /// @param subjects  Outlives the reader.
  StoredSessionReader(const SessionSubjects& subjects, v1::LatestSnapshot latest)
      : subjects_(subjects), latest_(std::move(latest)) {}

  /// Refused: a message that is malformed, or that does not lead to the root that it names.
  [[nodiscard]] Result<void> take(const StoredMessage& message);
  /// Refused: the messages make no scene, or one of another server's state than the latest snapshot's.
  [[nodiscard]] Result<StoredSession> finish() &&;

 private:
  const SessionSubjects& subjects_;
  v1::LatestSnapshot latest_;
  std::uint64_t lastSequence_ = 0;
  std::optional<SceneVersion> scene_;
  std::uint64_t epoch_ = 0;  // of scene_
  struct Assembly {
    std::uint64_t epoch = 0;
    v1::SnapshotBegin begin;
    std::vector<ObjectRecord> objects;
  };
  std::optional<Assembly> assembly_;

  [[nodiscard]] Result<void> take(const v1::SnapshotPart& part);
  [[nodiscard]] Result<void> take(const v1::PublishedCommit& published);
  [[nodiscard]] Result<void> complete(const v1::SnapshotEnd& end);
};

/// Nothing: the session was never published there.
[[nodiscard]] Result<std::optional<StoredSession>> readStoredSession(NatsConnection& connection,
                                                                     const SessionSubjects& subjects,
                                                                     const std::stop_token& stop = {});

}  // namespace haptics
