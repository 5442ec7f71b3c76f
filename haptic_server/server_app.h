#pragma once

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
  virtual ~ServerApp() = default;  ///< Stops.

  /// HOST:PORT where clients reach it; empty where it listens nowhere.
  [[nodiscard]] virtual std::string address() const = 0;
  /// A connection for a client in this process, on whose loop it is used. Any thread. The client leaves first.
  [[nodiscard]] virtual std::unique_ptr<Transport> connect(EventLoop& clientLoop) = 0;
  /// Any thread. An asset for a client in this process, which shares it with the scene; nothing where the scene has none of
  /// this name.
  [[nodiscard]] virtual std::optional<AssetContent> findAsset(const AssetName& name) const = 0;
  /// Reads the list of tokens again and cuts whoever has a withdrawn one. Any thread.
  virtual void refreshTokens() = 0;
  /// Stops the device, then the clients; writes summary and recording. Refused: a file that could not be written, a
  /// recording whose forces came out otherwise when it was played.
  [[nodiscard]] virtual Result<void> stop() = 0;
  /// After stop(): the scene's builder is still at something that cannot be interrupted, and to destroy the server is to
  /// wait for it. Nothing is lost by a process that ends without.
  [[nodiscard]] virtual bool isStillBuilding() const = 0;
};

}  // namespace haptics
