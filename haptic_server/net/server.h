#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "common/credentials/credentials.h"
#include "common/error/error.h"
#include "common/wire/event_loop.h"
#include "common/wire/transport.h"
#include "haptic_server/net/server_host.h"
#include "haptic_server/net/server_session.h"
#include "haptic_server/scene/scene_service.h"

namespace haptics {

class Connections;
class TcpListener;

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
  };
  struct Counters {
    std::uint32_t clients = 0;             ///< Welcomed and connected.
    std::uint64_t refusedConnections = 0;  ///< Turned away, or gone before they were welcomed.
  };

  static constexpr std::chrono::milliseconds kTokensEvery{250};

  /// Binds the address. Scene service and host outlive the server. Errors: malformed or not allowed address, port in use, a key
  /// that is not the certificate's.
  [[nodiscard]] static Result<std::unique_ptr<Server>> listen(Options options, SceneService& sceneService,
                                                              ServerHost& host);
  ~Server();  ///< Stops.

  void start();
  /// Closes every connection, takes what is left in the servo's queue and ends the thread. Before the scene service
  /// is destroyed.
  void stop();
  /// Looks at the list of tokens now. Connections whose token is not on it, or has another role there, are closed. Any thread.
  void refreshTokens();
  /// A connection from this process: the client's end, used on the client's loop. Any thread, between start() and stop().
  [[nodiscard]] std::unique_ptr<Transport> connect(EventLoop& clientLoop);
  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }  ///< 0 where it listens nowhere.
  [[nodiscard]] Counters counters() const noexcept;                    ///< Any thread.

 private:
  Server(Options options, SceneService& sceneService, ServerHost& host);
  [[nodiscard]] Result<void> open();
  void run();
  void serveEvery(std::chrono::microseconds period);
  void serve();

  const Options options_;
  SceneService& sceneService_;
  /// With the loop on which all that follows lives. Shared with tasks of other threads, which may end later than the
  /// server, and then do nothing.
  const std::shared_ptr<Connections> connections_;
  std::unique_ptr<TcpListener> listener_;
  std::uint16_t port_ = 0;
  Timer timer_, tokensTimer_, stopTimer_;
  std::chrono::microseconds servedEvery_{0};
  std::thread thread_;
};

}  // namespace haptics
