#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <stop_token>
#include <thread>

#include "graphics_client/mirror/server_link.h"
#include "haptic_server/server_app.h"

namespace haptics {

/// The server in the viewer's process, on threads of its own (paper section 2, Figure 1(a)). The scene's assets are in
/// memory once, shared by both; all else goes by messages, as between two processes (Figure 1(b)). The viewer's thread
/// waits for none of the server's: it draws while the scene is still being loaded.
class EmbeddedServer {
 public:
  /// Starts it, on another thread. It listens nowhere; mesh files lie beside the scene file, as for haptic_server.
  /// @param onFailure  Called once, on that thread, when it cannot start; stop() says why.
  EmbeddedServer(ServerOptions options, std::function<void()> onFailure);
  ~EmbeddedServer() = default;  ///< Stops.
  EmbeddedServer(const EmbeddedServer&) = delete;
  EmbeddedServer& operator=(const EmbeddedServer&) = delete;

  /// For a link to it, which is gone before it stops. An attempt to connect fails as long as it has not started.
  [[nodiscard]] ServerLink::Connect connect();
  [[nodiscard]] SharedAssets sharedAssets();

  /// Interrupts a start that is under way. Refused: why it could not start; what ServerApp::stop() refuses.
  [[nodiscard]] Result<void> stop();
  /// ServerApp::isStillBuilding().
  [[nodiscard]] bool isStillBuilding() const;

 private:
  void start(const ServerOptions& options, const std::stop_token& early);

  std::unique_ptr<ServerApp> app_;  // the starting thread's, until that is joined
  Result<void> started_;            // likewise
  std::atomic<ServerApp*> running_{nullptr};
  std::jthread starting_;
};

}  // namespace haptics
