#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/interruption/progress.h"
#include "common/telemetry/telemetry_sample.h"
#include "common/wire/framing.h"
#include "common/wire/transport.h"
#include "haptic_server/net/adoption_tracker.h"
#include "haptic_server/net/asset_sender.h"
#include "haptic_server/net/body_update_scheduler.h"
#include "haptic_server/net/rate_limit.h"
#include "haptic_server/net/session_host.h"
#include "haptic_server/net/session_uploads.h"
#include "haptic_server/net/telemetry_slot.h"
#include "haptic_server/net/tick_batches.h"

namespace haptics {

/// The server's fields of Welcome.
struct ServerIdentity {
  std::string name;
  std::string device;
  double servoRate_Hz = 0;
  double maxForce_N = 0;          ///< Newtons, the device's limit.
  std::string secondDevice = {};  ///< Of a second hand; empty: there is one.
  double secondMaxForce_N = 0;
};

/// Limits of one connection. Other values than these are for tests.
struct SessionLimits {
  FrameLimits frames = {};
  /// Before Welcome, which a Hello needs: who has not said who he is makes the server parse no more.
  static constexpr std::size_t kHelloBytes = 1U << 10;
  static constexpr std::size_t kViewerFrameBytes = 64U << 10;  ///< Largest frame from a client that may only view.
  static constexpr double kViewerBytesPerSecond = 64U << 10;
  static constexpr double kViewerBurstBytes = 256U << 10;
  /// Sustained edits per second, and how many may come at once; above, they come too early.
  double editsPerSecond = 200;
  double editBurst = 1000;
  /// Commits wait in the shared history while more than this is queued for the client.
  std::size_t sendAhead_bytes = 256U << 10;
  /// Replies cannot wait: with more than this queued the client is disconnected and left to resume.
  std::size_t backlog_bytes = 4U << 20;
};

/// One client's connection: the server's half of the protocol at the top of envelope.proto. No sockets, no clock, no
/// threads of its own: bytes through a Transport, time and the scene through the host. Every queue in it is bounded: a
/// client that does not read costs a few MiB until it is disconnected.
class ServerSession {
 public:
  static constexpr std::uint64_t kHelloWithin_ns = 3'000'000'000;
  static constexpr std::uint64_t kSilence_ns = 3'000'000'000;  ///< Dead after this long without a byte.
  static constexpr std::uint64_t kTakesNothing_ns =
      10'000'000'000;  ///< Gone after this long with bytes waiting for it.
  static constexpr std::uint64_t kHeartbeat_ns = 1'000'000'000;
  static constexpr double kMaxTelemetryRate_Hz = 1000;
  static constexpr std::size_t kMaxClientName = 64;  ///< Bytes.

  /// All three outlive the session.
  ServerSession(Transport& transport, SessionHost& host, const ServerIdentity& identity,
                const SessionLimits& limits = {});

  void start();
  void poll();                     ///< Timeouts, heartbeats, telemetry that has come due. Call every few milliseconds.
  void sceneChanged() { pump(); }  ///< The host's history has changed.
  /// The newest sample; sent when the client's rate and its connection allow it, else replaced by the next.
  void offerTelemetry(const TelemetrySample& sample, const TelemetrySample* second = nullptr);
  /// The servo feels `revision` since `tick`. Revisions in ascending order.
  void adopted(std::uint64_t revision, std::uint64_t tick);
  void editDecided(std::uint64_t clientSeq, const EditOutcome& outcome);
  /// Reports the progress of an undecided edit to a client that asked for it.
  void editProgress(std::uint64_t clientSeq, WorkStage stage, double share);
  void assetDecided(const ContentHash& hash, Result<std::shared_ptr<const Asset>> outcome);
  void dumped(const Result<std::string>& file);  ///< The file with the last seconds, or why there is none.
  /// Somebody else leads the simulated hand, or nobody any more: a client that has asked is notified.
  void handLeaderChanged(std::size_t hand);
  /// One that is no target is ignored: datagrams may be anything.
  void handTargetByDatagram(const v1::HandTarget& target);
  /// Sends a Refusal naming the bad field and closes; reported to the host.
  void refuse(const std::string& field, const std::string& reason);
  /// Closes without blame: the server stops, or a newer connection took the session over.
  void close(const std::string& why);

  [[nodiscard]] double telemetryRate_Hz() const noexcept { return telemetry_.rate_Hz(); }  ///< 0: none wanted.
  [[nodiscard]] bool wantsEveryTick() const noexcept { return batches_.wanted() && phase_ == Phase::kLive; }
  [[nodiscard]] bool welcomed() const noexcept { return phase_ == Phase::kLive; }
  [[nodiscard]] SessionId id() const noexcept { return id_; }  ///< 0 until Hello.
  [[nodiscard]] Role role() const noexcept { return role_; }   ///< Once welcomed.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  enum class Phase { kAwaitingHello, kLive, kClosed };
  Transport& transport_;
  SessionHost& host_;
  const ServerIdentity& identity_;
  const SessionLimits limits_;
  Phase phase_ = Phase::kAwaitingHello;
  SessionId id_ = 0;
  Role role_ = Role::kView;
  std::string name_;
  FrameDecoder decoder_{SessionLimits::kHelloBytes};
  RateLimit viewerBytes_{SessionLimits::kViewerBytesPerSecond, SessionLimits::kViewerBurstBytes};
  std::uint64_t started_ns_ = 0;
  std::uint64_t lastByte_ns_ = 0;
  std::uint64_t lastTaken_ns_ = 0;  // of what is sent, or there was nothing to take
  std::size_t backlog_bytes_ = 0;   // when that was looked at last
  std::uint64_t nextHeartbeat_ns_ = 0;
  struct Progress {
    WorkStage stage{};  // none while it waits for its turn
    double share = 0;
  };
  // Edits whose progress is wanted, by client_seq; each heartbeat sends it.
  std::map<std::uint64_t, Progress> undecided_;
  std::uint64_t nextMessageId_ = 1;

  std::uint64_t sentRevision_ = 0;  // the client has, or is about to have, this
  std::uint64_t epoch_ = 0;         // of the scene that the client was welcomed with
  AssetSender assets_;

  v1::Envelope telemetryEnvelope_;  // reused: encoding a sample allocates only its frame
  TelemetrySlot telemetry_;
  BodyUpdateScheduler bodies_;
  bool byDatagram_ = false;
  v1::Envelope batchEnvelope_;  // reused likewise
  TickBatches batches_;
  std::array<bool, kMaxLedHands> followsHandLeader_{};

  EditGate editGate_;
  AdoptionTracker adoptions_;
  SessionUploads uploads_;

  void received(std::span<const char> bytes);
  void handleAll(std::span<const char> bytes);
  void closed(const std::string& why);
  void handle(const v1::Envelope& envelope);
  void handleLive(const v1::Envelope& envelope);
  void handle(const v1::Hello& hello);
  void handle(const v1::Subscribe& subscribe);
  void handle(const v1::AssetRequest& request);
  void handle(const v1::EditRequest& request);
  void handle(const v1::AssetUpload& upload);
  void retryLater(std::uint64_t clientSeq);
  void handle(const v1::ClockProbe& probe);
  void handle(const v1::LeadHand& request);
  void handle(const v1::HandTarget& target);
  void handle(const v1::SetWorkspace& message);
  void handle(const v1::AddWrench& message);
  void sendHandLeader(std::size_t hand, const std::string& refused);
  void reportStatus(bool deformed);
  void dump();

  void pump();
  void sendTelemetry(bool lineIsFree);
  void sendTicks();
  void addBodiesAndDents(v1::Telemetry& message);
  void sendCommits();
  void sendLive();
  void tellProgress();
  void sendProgress(std::uint64_t clientSeq, WorkStage stage, double share, std::size_t place);
  void sendHeartbeat();
  void noteProgress(std::uint64_t now_ns);
  void send(v1::Envelope& envelope);
  void send(const v1::AssetUploadReply& reply);
};

}  // namespace haptics
