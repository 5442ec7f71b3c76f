#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <string>
#include <thread>

#include "common/credentials/credentials.h"
#include "common/telemetry/added_wrench.h"
#include "common/telemetry/hand_command.h"
#include "common/wire/endpoint.h"
#include "common/wire/event_loop.h"
#include "common/wire/transport.h"
#include "graphics_client/mirror/client_callbacks.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/mirror/session_follower.h"

namespace haptics {

/// A client's connection to the server, kept by a thread of its own: it connects, mirrors the scene, and reconnects for
/// ever after a random 50 to 600 ms (seconds after a refusal). Every method may be called from any thread, except
/// waitUntil from a callback. Callbacks run on the link's thread and must be short. The destructor closes the
/// connection and joins the thread; no callback comes after it.
class ServerLink {
 public:
  using Connected = std::function<void(Result<std::unique_ptr<Transport>>)>;
  /// Begins one attempt to reach the server, on the link's loop. The function is to be called once, on the loop's thread
  /// and never from within; dropping what is returned abandons the attempt.
  using Connect = std::function<std::shared_ptr<void>(EventLoop&, Connected)>;

  struct Options {
    Endpoint server;                                 ///< Without a host: none, as after disconnect().
    std::string clientName;                          ///< For the server's log, at most 64 bytes.
    std::optional<ClientCredentials> credentials{};  ///< Of the server; nothing: it is spoken to without TLS.
    double telemetryRate_Hz = 60;                    ///< 0: none.
    bool fetchAssets = true;                         ///< false: records only; hashesEqual then stays false.
    bool datagrams = false;           ///< Telemetry by UDP where the server offers it and the network lets it through.
    bool followsHand = false;         ///< Hears who leads the simulated hand without asking for the lead.
    std::size_t hand = 0;             ///< Which one it leads, below kMaxLedHands.
    TicksCallback onTicks{};          ///< Gets every tick, on the link's thread. Empty: the newest samples alone.
    Connect connect{};                ///< Another way than TCP to `server`: a server in this process. Empty: TCP.
    SessionFollower follower{};       ///< Called on the link's thread.
    std::optional<HeldScene> held{};  ///< As ClientSession::Options.
    SharedAssets sharedAssets{};  ///< Of a server in this process; called on the link's thread. Empty: all are fetched.
  };

  explicit ServerLink(Options options);
  ~ServerLink();
  ServerLink(const ServerLink&) = delete;
  ServerLink& operator=(const ServerLink&) = delete;

  /// Leaves the server for another one, over TCP; all else is as the options say. The view starts anew; what was asked
  /// of the one before may never be answered. Waits for no server. Not while a thread is in waitUntil().
  void connectTo(const Endpoint& server, std::optional<ClientCredentials> credentials);
  /// Leaves the server. LinkState::kClosed follows.
  void disconnect() { connectTo({}, {}); }
  /// Another way than TCP was given.
  [[nodiscard]] bool isInProcess() const { return static_cast<bool>(options_.connect); }

  /// The newest view; never null. Holding it keeps it, it does not change.
  [[nodiscard]] std::shared_ptr<const MirrorView> latest() const;
  /// The first view, from now on, of which the condition holds; null after the timeout.
  [[nodiscard]] std::shared_ptr<const MirrorView> waitUntil(const std::function<bool(const MirrorView&)>& condition,
                                                            std::chrono::nanoseconds timeout) const;

  /// Queues an edit; it is sent when connected and resent until replied, and applied exactly once. What does not fit a
  /// frame, or the queue of kMaxPendingEdits, is answered at once with Rejected.
  void submit(v1::Transaction transaction, EditCallbacks callbacks);
  /// Sends an asset's canonical bytes (encodeMesh, encodeField, encodeVertexValues), so that edits of this link may name
  /// its hash.
  void upload(AssetKind kind, std::string bytes, UploadCallbacks callbacks);
  /// By the asset's hash; the upload finishes as refused and the server frees what it has of it.
  void cancelUpload(const ContentHash& asset);
  void requestStatus(StatusCallback callback, bool deformed = false);
  void requestDump(DumpCallback callback);
  void setTelemetryRate(double rate_Hz);
  /// As ClientSession::leadHand(), commandHand(), addWrench() and setWorkspace().
  void leadHand(bool lead);
  void commandHand(const HandCommand& command);
  void addWrench(std::size_t hand, const Wrench& wrench);
  void setWorkspace(const v1::SetWorkspace& message);

 private:
  struct Worker;
  Options options_;
  mutable std::shared_mutex mutex_;  // guards which worker it is
  std::unique_ptr<Worker> worker_;
  std::jthread leaving_;  // says farewell to the server before
};

}  // namespace haptics
