#include "graphics_client/relay/relay.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "common/clock/monotonic.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/relay/published_surfaces.h"
#include "graphics_client/relay/session_publisher.h"

namespace haptics {
namespace {

constexpr std::uint64_t kHeartbeat_ns = 1'000'000'000;
/// Before NATS is tried again: the first after a round that lasted, then twice the one before, up to the longest.
constexpr std::chrono::milliseconds kFirstPause{500}, kLongestPause{8000};
constexpr std::uint64_t kLasted_ns = 10'000'000'000;
/// Between looks at what is new: an asset or a failure waits no longer.
constexpr std::chrono::milliseconds kLook{20};

/// A round: publishes until something fails.
class Round {
 public:
  Round(const RelayOptions& options, SessionPublisher& publisher, const std::function<void(const std::string&)>& say)
      : publisher_(publisher),
        say_(say),
        link_({.server = options.server,
               .clientName = "haptic_relay",
               .credentials = options.credentials,
               .telemetryRate_Hz = options.sampleRate_Hz,
               .follower = publisher.follower(),
               .held = publisher.held()}) {}

  [[nodiscard]] RelayFailure run(const std::atomic<bool>& stop) {
    while (!stop) {
      if (auto failure = publisher_.failure()) return *std::move(failure);
      look(*link_.latest());
      std::this_thread::sleep_for(kLook);
    }
    return {};
  }

 private:
  void look(const MirrorView& view) {
    if (view.linkText != linkText_) say_(linkText_ = view.linkText);
    if (view.link != LinkState::kLive) return;
    if (view.scene != scene_ || view.assetBytes != assetBytes_) publishAssets(view);
    if (const auto made = surfaces_.takeMade()) publisher_.publishSurface(made->key, made->bytes);
    const std::uint64_t now_ns = monotonicNow_ns();
    if (now_ns < nextHeartbeat_ns_) return;
    nextHeartbeat_ns_ = now_ns + kHeartbeat_ns;
    publisher_.publishHeartbeat(view);
    if (const auto damaged = publisher_.checkStored()) {
      surfaces_.makeAgain(*damaged);
      publishAssets(view);
    }
  }

  void publishAssets(const MirrorView& view) {
    scene_ = view.scene;
    assetBytes_ = view.assetBytes;
    surfaces_.want(view);
    publisher_.publishAssets(view, surfaces_.keys());
  }

  SessionPublisher& publisher_;
  PublishedSurfaces surfaces_;
  const std::function<void(const std::string&)>& say_;
  ServerLink link_;  // its thread ends before the publisher
  std::string linkText_;
  std::shared_ptr<const SceneVersion> scene_;
  std::size_t assetBytes_ = 0;
  std::uint64_t nextHeartbeat_ns_ = 0;
};

}  // namespace

Result<void> runRelay(const RelayOptions& options, const std::atomic<bool>& stop,
                      const std::function<void(const std::string&)>& say) {
  std::string said;
  auto pause = kFirstPause;
  while (!stop) {
    const std::uint64_t begin_ns = monotonicNow_ns();
    auto publisher = SessionPublisher::open(options.nats, options.subjects, options.replicas);
    if (publisher) say("publishing the stream " + options.subjects.sceneStream);
    const RelayFailure failure = publisher ? Round(options, **publisher, say).run(stop) : publisher.error();
    if (failure.isFinal) return tl::unexpected(failure.why);
    if (stop) break;
    if (const std::string text = failure.why.text() + "; trying again"; text != said) say(said = text);
    if (publisher) said.clear();
    if (monotonicNow_ns() - begin_ns > kLasted_ns) pause = kFirstPause;
    const std::uint64_t end_ns = monotonicNow_ns() + std::chrono::nanoseconds(pause).count();
    while (!stop && monotonicNow_ns() < end_ns) std::this_thread::sleep_for(kLook);
    pause = std::min(kLongestPause, 2 * pause);
  }
  return {};
}

}  // namespace haptics
