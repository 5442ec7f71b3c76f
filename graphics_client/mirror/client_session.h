#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "common/clock/clock_offset.h"
#include "common/telemetry/added_wrench.h"
#include "common/wire/framing.h"
#include "common/wire/transport.h"
#include "graphics_client/mirror/asset_fetcher.h"
#include "graphics_client/mirror/asset_uploader.h"
#include "graphics_client/mirror/client_limits.h"
#include "graphics_client/mirror/datagram_path.h"
#include "graphics_client/mirror/edit_outbox.h"
#include "graphics_client/mirror/hand_lead.h"
#include "graphics_client/mirror/mirror.h"
#include "graphics_client/mirror/session_follower.h"

namespace haptics {

/// The client's half of the protocol (top of envelope.proto), over one connection after another: no sockets, threads
/// or clock of its own. Its owner makes the connections, hands in what arrives, and calls poll().
///
/// All times are nanoseconds of the client's monotonic clock, never going back. Callbacks of edits, uploads and status
/// requests run within received() and must not destroy the session.
class ClientSession {
 public:
  /// Proof of life to the server; of no more use below the server's limit of 3 s.
  static constexpr std::uint64_t kHeartbeat_ns = 1'000'000'000;
  /// Without a byte for this long the connection counts as dead. Shorter: links that only stall are cut.
  static constexpr std::uint64_t kSilence_ns = 3'000'000'000;
  /// Wait before the next attempt: random within these, so that the clients of a restarted server do not come at once.
  static constexpr std::uint64_t kMinReconnectDelay_ns = 50'000'000;
  static constexpr std::uint64_t kMaxReconnectDelay_ns = 600'000'000;
  /// After a refusal: a person has to change something first.
  static constexpr std::uint64_t kRefusedDelay_ns = 5'000'000'000;
  /// Clock probes: 20 Hz until the estimate rests on a full window, then as often as clocks drift visibly.
  static constexpr std::uint64_t kFirstProbes_ns = 50'000'000;
  static constexpr std::uint64_t kLaterProbes_ns = 1'000'000'000;
  /// Longest time between two calls of poll(); half the shortest interval above.
  static constexpr std::uint64_t kPoll_ns = 20'000'000;
  /// Assets hashed anew at each heartbeat, in turn: some milliseconds. More would delay telemetry.
  static constexpr std::size_t kAudit_bytes = 4U << 20;
  /// An upload's next chunk is queued below this backlog, so that edits and heartbeats find a short queue.
  static constexpr std::size_t kUploadBacklog_bytes = 64U << 10;

  struct Options {
    std::uint64_t session = 0;  ///< Random, not 0; kept over reconnects: edits are exactly-once within it.
    std::string clientName;
    std::string token;
    double telemetryRate_Hz = 60;  ///< 0: none.
    bool fetchAssets = true;
    bool datagrams = false;          ///< Telemetry by UDP where the server offers it and the network lets it through.
    bool followsHand = false;        ///< Hears who leads the simulated hand without asking for the lead.
    std::size_t hand = 0;            ///< Which one it leads, below kMaxLedHands.
    TicksCallback onTicks = {};      ///< Every tick is wanted. Empty: the newest samples alone.
    SharedAssets sharedAssets = {};  ///< Asked before an asset is fetched. Empty: the server is in another process.
    FrameLimits frames = {};         ///< Others than the protocol's are for tests.
    SessionFollower follower = {};
    std::optional<HeldScene> held = {};  ///< Resumed with where the server still can.
  };

  explicit ClientSession(Options options);

  /// A new connection, which outlives its use: until connectionOver() or connectionLost().
  void connected(Transport& transport, std::uint64_t now_ns);
  void received(std::span<const char> bytes, std::uint64_t now_ns);
  void drained() { pumpUploads(); }
  void poll(std::uint64_t now_ns);
  /// A datagram came in at this host.
  void datagramReceived(std::span<const char> bytes, const Endpoint& from, std::uint64_t now_ns);
  /// What is to be sent now; ask with each poll().
  /// Ask until there is none.
  [[nodiscard]] std::optional<DatagramPath::Datagram> nextDatagram(std::uint64_t now_ns);
  /// The session has no more use for the connection: drop it, then call connectionLost() with overReason().
  [[nodiscard]] bool connectionOver() const noexcept { return !over_.empty(); }
  [[nodiscard]] const std::string& overReason() const noexcept { return over_; }
  /// There is no speaking with this server, and trying again soon will not help: as if it had refused.
  void turnedAway(const std::string& why);
  /// The connection, or the attempt to make one, is at its end.
  void connectionLost(const std::string& why);
  /// How long to wait now before the next attempt.
  [[nodiscard]] std::uint64_t reconnectDelay_ns();

  void submit(v1::Transaction transaction, EditCallbacks callbacks);
  void upload(AssetKind kind, std::string bytes, UploadCallbacks callbacks);
  void cancelUpload(const ContentHash& asset);
  /// Asked again after a reconnect until it is answered.
  /// @param deformed  With the hash of what gives. Requests before the answer share it, as the last of them asked.
  void requestStatus(StatusCallback callback, bool deformed = false);
  /// Asked again after a reconnect until it is answered.
  void requestDump(DumpCallback callback);
  void setTelemetryRate(double rate_Hz);
  /// Asks for the lead of the simulated hand, or gives it back; MirrorView::hand says what came of it. Without a
  /// connection, and for the time after one is lost, nobody leads.
  void leadHand(bool lead, std::uint64_t now_ns);
  /// Ignored while another leads.
  void commandHand(const HandCommand& command, std::uint64_t now_ns);
  /// Added to the force of hand 0 or 1 for 0.1 s at most: to be called again and again. Without a connection, of who may not
  /// edit, or of a hand that the server does not have it is ignored.
  void addWrench(std::size_t hand, const Wrench& wrench);

  /// Of one who may not edit, or with a number that is refused, the server ends the connection. Without one it is ignored.
  void setWorkspace(const v1::SetWorkspace& message);

  [[nodiscard]] const Mirror& mirror() const noexcept { return mirror_; }
  [[nodiscard]] MirrorView view(std::uint64_t now_ns) const;
  /// Grows with everything that a view would show.
  [[nodiscard]] std::uint64_t changes() const noexcept { return changes_; }

 private:
  /// The snapshot that is arriving.
  struct Snapshot {
    std::uint64_t revision = 0;
    std::uint64_t objectCount = 0;
    std::vector<ObjectRecord> objects;
  };
  enum class Phase { kDown, kHello, kSyncing, kLive };

  Options options_;
  std::mt19937_64 random_;
  Mirror mirror_;
  ClockOffset clock_;
  EditOutbox edits_;
  AssetFetcher assets_;
  AssetUploader uploads_;
  DatagramPath datagrams_;
  std::optional<v1::HandTarget> targetByDatagram_;  // unsent
  HandLead hand_{options_.hand};
  std::uint64_t datagramPathsLost_ = 0;
  std::vector<StatusCallback> statusWaiters_;
  bool statusDeformed_ = false;
  std::vector<DumpCallback> dumpWaiters_;
  std::uint64_t changes_ = 1;
  bool refused_ = false;        // until the next Welcome
  bool needsSnapshot_ = false;  // roots differed, or the server could not resume: the next Hello claims nothing
  std::string linkText_ = "not connected";
  std::string trouble_;  // why the last connection ended; nothing once one is live
  v1::Welcome welcome_;  // the last
  std::uint64_t connections_ = 0;

  // The present connection:
  Transport* transport_ = nullptr;
  Phase phase_ = Phase::kDown;
  std::string over_;
  FrameDecoder decoder_;
  std::uint64_t nextMessageId_ = 1;
  std::uint64_t lastByte_ns_ = 0;
  std::uint64_t nextHeartbeat_ns_ = 0;
  std::uint64_t nextProbe_ns_ = 0;
  std::uint64_t probesAnswered_ = 0;
  std::optional<Snapshot> snapshot_;
  bool behindAtHeartbeat_ = false;
  bool byDatagram_ = false;  // as last subscribed

  void handle(const v1::Envelope& envelope, std::uint64_t now_ns);
  void handleGreeting(const v1::Envelope& envelope, std::uint64_t now_ns);
  void handle(const v1::Welcome& welcome, std::uint64_t now_ns);
  void handle(const v1::Refusal& refusal);
  void handle(const v1::SnapshotBegin& begin);
  void handle(const v1::SnapshotObjects& objects);
  void handle(const v1::SnapshotEnd& end);
  void handle(const v1::Commit& message);
  void handle(const v1::Heartbeat& heartbeat);
  void handle(const v1::TelemetryBatch& batch);
  void handle(const v1::AssetChunk& chunk);
  void handle(const v1::ClockReply& reply, std::uint64_t now_ns);

  void sceneChanged();
  void becomeLive();
  void show(const v1::Telemetry& sample);
  void followDatagramPath();
  [[nodiscard]] std::string liveText() const;
  [[nodiscard]] std::string withTrouble(std::string text) const;
  [[nodiscard]] Result<void> shareAssets();
  void requestAssets();
  void pumpEdits();
  void pumpUploads();
  void pumpHand(std::uint64_t now_ns);
  void sendHello();
  void sendSubscribe();
  void sendStatusRequest();
  void sendDumpRequest();
  void send(v1::Envelope& envelope);
  void over(const std::string& why);
  void resync(const Error& why);
  void leave(const Error& why);
};

}  // namespace haptics
