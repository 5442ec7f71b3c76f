#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/credentials/credentials.h"
#include "common/error/error.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "common/wire/event_loop.h"
#include "common/wire/transport.h"
#include "haptic_server/net/server_session.h"
#include "haptic_server/scene/scene_room.h"

namespace haptics {

/// The network thread: accepts clients, runs their sessions, carries the servo's samples to them. The servo never
/// wakes it: it looks into the servo's queue on its own timer.
class Server {
 public:
  struct Options {
    std::string listen = "127.0.0.1:0";  ///< HOST:PORT; port 0: any free one. Empty: none, only connect().
    /// With them every client speaks TLS 1.3 and has the role of its token, as the folder's list has it at any time: it is
    /// looked at every kTokensEvery. Without, every client may edit.
    std::optional<ServerCredentials> credentials;
    bool allowInsecureLan = false;  ///< Without it, and without credentials, only loopback addresses are accepted.
    ServerIdentity identity;
    /// The servo's queue: takes its oldest sample, false when empty. Called on the network thread only.
    std::function<bool(TelemetrySample&)> popTelemetry;
    /// Where the objects that move are, null when nothing has changed since the last call; may be empty. Likewise.
    std::function<const MotionState*()> takeMotion = nullptr;
    /// What the objects gave the hand, likewise.
    std::function<const EnergyState*()> takeEnergy = nullptr;
    /// Records the last seconds and calls back, from any thread, with the file or why there is none; may be empty.
    std::function<void(std::function<void(const Result<std::string>&)>)> dump = {};
    /// What a Status says of servo, device and uptime; may be empty. Network thread.
    std::function<void(v1::Status&)> fillStatus;
    std::function<void(const std::string&)> log;  ///< One line; may be empty. Network thread.
  };
  struct Counters {
    std::uint32_t clients = 0;             ///< Welcomed and connected.
    std::uint64_t refusedConnections = 0;  ///< Turned away, or gone before they were welcomed.
  };

  static constexpr std::chrono::milliseconds kTokensEvery{250};
  /// Connections that have not been welcomed yet. Beyond, the oldest gives way to the newest: those who open connections
  /// and say nothing keep nobody out who speaks at once.
  static constexpr std::size_t kMaxHalfOpen = 64;

  /// Binds the address. Errors: malformed or not allowed address, port in use, a key that is not the
  /// certificate's.
  [[nodiscard]] static Result<std::unique_ptr<Server>> listen(Options options, SceneRoom& room);
  ~Server();  ///< Stops.
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  void start();
  /// Closes every connection, takes what is left in the servo's queue and ends the thread. Before the room is
  /// destroyed.
  void stop();
  /// Looks at the list of tokens now. Connections whose token is not on it, or has another role there, are closed. Any thread.
  void refreshTokens();
  /// A connection from this process: the client's end, used on the client's loop. Any thread, between start() and stop().
  [[nodiscard]] std::unique_ptr<Transport> connect(EventLoop& clientLoop);
  [[nodiscard]] std::uint16_t port() const noexcept;  ///< 0 where it listens nowhere.
  [[nodiscard]] Counters counters() const noexcept;   ///< Any thread.

 private:
  class Impl;
  explicit Server(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace haptics
