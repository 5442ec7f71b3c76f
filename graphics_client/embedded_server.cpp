#include "graphics_client/embedded_server.h"

#include <exception>
#include <filesystem>
#include <utility>

#include "common/interruption/interruption.h"

namespace haptics {

EmbeddedServer::EmbeddedServer(ServerOptions options, std::function<void()> onFailure) {
  options.listen.clear();
  if (!options.scene.empty()) {
    const auto folder = std::filesystem::absolute(options.scene).parent_path();
    options.assets.insert(options.assets.begin(), folder);
  }
  starting_ = std::jthread(
      [this, options = std::move(options), onFailure = std::move(onFailure)](const std::stop_token& early) {
        start(options, early);
        if (!started_) onFailure();
      });
}

void EmbeddedServer::start(const ServerOptions& options, const std::stop_token& early) {
  const Interruptible work(early);
  try {
    auto app = ServerApp::start(options);
    if (app) {
      app_ = *std::move(app);
      running_ = app_.get();
    } else if (!early.stop_requested()) {
      started_ = tl::unexpected(std::move(app).error());
    }
  } catch (const Interrupted&) {  // by stop()
  } catch (const std::exception& failure) {
    started_ = refused("", failure.what());
  }
}

ServerLink::Connect EmbeddedServer::connect() {
  return [this](EventLoop& loop, const ServerLink::Connected& done) {
    loop.post([this, &loop, done] {
      ServerApp* const app = running_;
      if (app == nullptr) return done(refused("", "the server in this process is still loading its scene"));
      done(app->connect(loop));
    });
    return std::shared_ptr<void>();
  };
}

SharedAssets EmbeddedServer::sharedAssets() {
  return [this](const AssetName& name) -> std::optional<AssetContent> {
    const ServerApp* const app = running_;
    return app == nullptr ? std::nullopt : app->findAsset(name);
  };
}

Result<void> EmbeddedServer::stop() {
  starting_.request_stop();
  if (starting_.joinable()) starting_.join();
  if (!started_ || !app_) return started_;
  return app_->stop();
}

bool EmbeddedServer::isStillBuilding() const { return app_ && app_->isStillBuilding(); }

}  // namespace haptics
