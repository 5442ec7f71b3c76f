#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/assets/asset_content.h"
#include "common/error/error.h"
#include "common/wire/event_loop.h"
#include "common/wire/transport.h"
#include "haptic_server/server_options.h"

namespace haptics {

/// The whole server: device, servo, scene, network. In a process of its own, or in the viewer's.
class ServerApp {
 public:
  /// Everything runs when it returns. `onEnd` is called once, on a thread of the server, when a recording that it plays is
  /// at its end. May be interrupted (Interruptible) while files are imported. Refused, naming the option or file: what
  /// cannot be had.
  [[nodiscard]] static Result<std::unique_ptr<ServerApp>> start(const ServerOptions& options,
                                                                std::function<void()> onEnd = {});
  ~ServerApp();  ///< Stops.
  ServerApp(const ServerApp&) = delete;
  ServerApp& operator=(const ServerApp&) = delete;

  /// HOST:PORT where clients reach it; empty where it listens nowhere.
  [[nodiscard]] std::string address() const;
  /// A connection for a client in this process, on whose loop it is used. Any thread. The client leaves first.
  [[nodiscard]] std::unique_ptr<Transport> connect(EventLoop& clientLoop);
  /// Any thread. An asset for a client in this process, which shares it with the scene; nothing where the scene has none of
  /// this name.
  [[nodiscard]] std::optional<AssetContent> findAsset(const AssetName& name) const;
  /// Reads the list of tokens again and cuts whoever has a withdrawn one. Any thread.
  void refreshTokens();
  /// Stops the device, then the clients; writes summary and recording. Refused: a file that could not be written, a
  /// recording whose forces came out otherwise when it was played.
  [[nodiscard]] Result<void> stop();
  /// After stop(): the scene's builder is still at something that cannot be interrupted, and to destroy the server is to
  /// wait for it. Nothing is lost by a process that ends without.
  [[nodiscard]] bool isStillBuilding() const;

 private:
  class Impl;
  explicit ServerApp(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptics
