#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/canonical_bytes.h"
#include "common/nats/nats_handles.h"
#include "graphics_client/audience/nats_connection.h"
#include "graphics_client/audience/session_subjects.h"
#include "graphics_client/audience/stored_session.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/mirror/session_follower.h"
#include "haptics/v1/audience.pb.h"

namespace haptics {

/// Why a relay cannot go on.
struct RelayFailure {
  Error why;
  bool isFinal = false;  ///< Trying again does not help: somebody has to change something first.
};

/// Publishes one session (audience.proto). The scene's stream has one writer: each message is stored only behind the one
/// before it, so that two relays, or a message that was lost, are noticed. After a failure it is of no more use: what was
/// stored is read anew by the next one.
class SessionPublisher {
 public:
  /// A snapshot is published after so many commits or bytes of them. More: who comes late reads longer. Fewer: more is stored.
  static constexpr std::uint64_t kCommitsPerSnapshot = 256;
  static constexpr std::size_t kBytesPerSnapshot = 8U << 20;
  /// A stream that would grow beyond is full: snapshots of two times the largest scene with the commits between them, and
  /// all assets that a client holds.
  static constexpr std::int64_t kMaxScene_bytes = 256LL << 20;
  static constexpr std::int64_t kMaxAssets_bytes = 1LL << 30;
  /// Newest-only messages are dropped while more than this waits for the line.
  static constexpr std::size_t kMaxUnsentForSample_bytes = 64U << 10;

  /// Makes the streams if they are not there, and reads what they hold. Failed: another relay publishes this session, a
  /// stream is full or may not be written, or NATS does not answer.
  /// @param replicas  Of streams that it makes: so many servers of a cluster hold them.
  [[nodiscard]] static tl::expected<std::unique_ptr<SessionPublisher>, RelayFailure> open(
      const NatsOptions& options, const SessionSubjects& subjects, int replicas);
  ~SessionPublisher();
  SessionPublisher(const SessionPublisher&) = delete;
  SessionPublisher& operator=(const SessionPublisher&) = delete;

  /// What was published before, to be resumed with; nothing: there is nothing, or nothing that can be read.
  [[nodiscard]] std::optional<HeldScene> held() const;
  /// To be called on one thread.
  [[nodiscard]] SessionFollower follower();
  /// The view's assets that are not stored yet. Removed is what neither its scene nor one of `surfaces` names any more.
  void publishAssets(const MirrorView& view, const std::set<ContentHash>& surfaces);
  void publishSurface(const ContentHash& key, const std::string& bytes);
  void publishHeartbeat(const MirrorView& view);
  /// Reads some of the stored chunks again, others at each call.
  /// @return An asset or surface of which one is not as it was published; who publishes it again puts that right.
  [[nodiscard]] std::optional<ContentHash> checkStored();
  [[nodiscard]] std::optional<RelayFailure> failure() const;

 private:
  SessionPublisher(std::unique_ptr<NatsConnection> connection, const SessionSubjects& subjects, int replicas)
      : connection_(std::move(connection)), subjects_(subjects), replicas_(replicas) {}

  std::unique_ptr<NatsConnection> connection_;
  SessionSubjects subjects_;
  int replicas_;
  std::optional<StoredSession> stored_;
  nats::Subscription claim_;
  nats::JetStream scene_, assets_;  // apart, so that a commit never waits for room behind assets

  // The follower's thread:
  v1::Welcome welcome_;
  std::uint64_t lastSequence_ = 0;      // of the scene's stream
  std::uint64_t snapshotSequence_ = 0;  // of the newest snapshot; 0: none
  std::uint64_t commitsSince_ = 0;
  std::size_t bytesSince_ = 0;

  // Of who publishes assets:
  struct Stored {
    ContentHash name;
    std::vector<ContentHash> chunks;  // of each message; empty: not known to be right, as what an earlier relay stored
  };
  std::map<std::string, Stored> assetsStored_;  // by the name in hexadecimal
  std::pair<std::string, std::uint64_t> nextCheck_;
  std::uint64_t lastStored_ns_ = 0;

  mutable std::mutex mutex_;  // guards failure_
  std::optional<RelayFailure> failure_;

  [[nodiscard]] std::optional<RelayFailure> checkPayload();
  [[nodiscard]] std::optional<RelayFailure> claim();
  [[nodiscard]] std::optional<RelayFailure> makeContexts();
  [[nodiscard]] std::optional<RelayFailure> prepareStreams();
  [[nodiscard]] std::optional<RelayFailure> readStored();
  void snapshot(const SceneVersion& scene);
  void commit(const v1::Commit& commit, const SceneVersion& after);
  void telemetry(const v1::Telemetry& telemetry);
  void store(const std::string& subject, const google::protobuf::Message& message, const std::string& id = {});
  void storeAsset(const ContentHash& name, v1::AssetKind kind, const CanonicalBytes& bytes);
  void noteStored(const jsStreamInfo& info);
  void purge(const std::string& stream, const std::string& subject, std::uint64_t upTo);
  void fail(RelayFailure failure);
  static void acknowledged(jsCtx* context, natsMsg* message, jsPubAck* ack, jsPubAckErr* error, void* self) noexcept;
};

}  // namespace haptics
