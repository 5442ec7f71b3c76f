#include "graphics_client/openigtlink/bridge.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/clock/unix_time.h"
#include "common/text/printable.h"
#include "common/wire/event_loop.h"
#include "common/wire/tcp.h"
#include "graphics_client/mirror/object_poses.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/openigtlink/igtl_message.h"

namespace haptics::igtl {
namespace {

constexpr std::size_t kMaxPeers = 16;
constexpr std::chrono::milliseconds kLook{100};
/// Objects that stand still are sent again so often: a peer may have just begun to listen to them.
constexpr std::uint64_t kStill_ns = 1'000'000'000;

struct Peer {
  std::unique_ptr<Transport> transport;
  Reader reader;
};

class Bridge {
 public:
  Bridge(const BridgeOptions& options, const std::atomic<bool>& stop)
      : options_(options),
        link_({.server = options.server,
               .clientName = "haptic_igtl",
               .credentials = options.credentials,
               .telemetryRate_Hz = options.rate_Hz}),
        poses_(link_, options.say),
        look_(loop_.every(kLook, [this, &stop] { look(stop); })),
        send_(loop_.every(std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / options.rate_Hz)),
                          [this] { send(); })) {}

  [[nodiscard]] Result<void> run() {
    auto listener = TcpListener::open(loop_, options_.listen,
                                      [this](std::unique_ptr<Transport> transport) { accept(std::move(transport)); });
    if (!listener) return tl::unexpected(std::move(listener).error());
    options_.say("OpenIGTLink at " + (*listener)->local().text());
    loop_.run();
    peers_.clear();
    return {};
  }

 private:
  const BridgeOptions& options_;
  EventLoop loop_;
  ServerLink link_;
  ObjectPoses poses_;
  std::map<std::uint64_t, Peer> peers_;  // by number
  std::uint64_t nextPeer_ = 0;
  std::string linkText_;
  std::set<std::string> tooLong_;  // names of objects, said
  std::uint64_t sentTick_ = 0, stillSent_ns_ = 0;
  Timer look_, send_;

  void look(const std::atomic<bool>& stop) {
    if (stop) return loop_.stop();
    const auto view = link_.latest();
    if (view->linkText != linkText_) options_.say(linkText_ = view->linkText);
  }

  void accept(std::unique_ptr<Transport> transport) {
    if (peers_.size() >= kMaxPeers) {
      options_.say(transport->peer() + " is turned away: " + std::to_string(kMaxPeers) + " are connected");
      return;
    }
    const std::uint64_t number = nextPeer_++;
    options_.say(transport->peer() + " connected");
    Peer& peer = peers_[number] = {std::move(transport), {}};
    peer.transport->start({.received = [this, number](std::span<const char> bytes) { receive(number, bytes); },
                           .drained = [] {},
                           .closed = [this, number](const std::string& why) { drop(number, why); }});
    stillSent_ns_ = 0;
  }

  void drop(std::uint64_t number, const std::string& why) {
    options_.say(printable(peers_.at(number).transport->peer() + " left: " + why));
    peers_.erase(number);
  }

  void receive(std::uint64_t number, std::span<const char> bytes) {
    const auto read = peers_.at(number).reader.read(bytes, [this](const Message& message) {
      if (message.type != "TRANSFORM") return;
      if (const auto pose = poseFrom(message.content); pose) {
        poses_.set(message.name, *pose);
      } else {
        poses_.refuse(message.name, pose.error().text());
      }
    });
    if (!read) drop(number, "what it sent is no OpenIGTLink: " + read.error().text());
  }

  void send() {
    const auto view = link_.latest();
    if (peers_.empty() || view->link != LinkState::kLive || !view->sample || view->sample->tick == sentTick_) return;
    sentTick_ = view->sample->tick;
    const std::uint64_t now_ns = monotonicNow_ns();
    const std::int64_t unix_ns = unixNow_ns() - static_cast<std::int64_t>(1e9 * view->telemetryAgeAt_s(now_ns));
    const bool still = now_ns - stillSent_ns_ >= kStill_ns;
    if (still) stillSent_ns_ = now_ns;
    std::string bytes = handsOf(*view, unix_ns);
    for (const SceneVersion::Object& object : view->scene->objects()) {
      if (!still && !view->bodies.contains(object->id)) continue;
      if (object->name.size() > kMaxName) {
        if (tooLong_.insert(object->name).second)
          options_.say("\"" + object->name + "\" is not sent: its name is longer than OpenIGTLink's 20 characters");
        continue;
      }
      bytes += transform(object->name, unix_ns, view->poseOf(*object));
    }
    for (auto& [number, peer] : peers_) {
      if (peer.transport->backlog() == 0) peer.transport->send(bytes);
    }
  }

  [[nodiscard]] static std::string handsOf(const MirrorView& view, std::int64_t unix_ns) {
    static constexpr std::array<const char*, kMaxLedHands> kPrefix{"", "Second"};
    std::string bytes;
    for (std::size_t hand = 0; hand < kMaxLedHands; ++hand) {
      const TelemetrySample* const felt = view.felt(hand);
      if (felt == nullptr) continue;
      const std::string prefix = kPrefix[hand];
      const Quat turned = hand == 0 && view.tool ? view.tool->deviceRotation : Quat(1, 0, 0, 0);
      bytes += transform(prefix + "HIP", unix_ns, {turned, felt->hip});
      bytes += transform(prefix + "IHIP", unix_ns, {turned, felt->ihip});
      bytes += position(prefix + "Stylus", unix_ns, {turned, felt->hip});
      bytes += force(prefix + "Force", unix_ns, felt->force.written);
    }
    return bytes;
  }
};

}  // namespace

Result<void> runBridge(const BridgeOptions& options, const std::atomic<bool>& stop) {
  return Bridge(options, stop).run();
}

}  // namespace haptics::igtl
