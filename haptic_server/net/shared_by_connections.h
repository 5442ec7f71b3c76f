#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/credentials/credentials.h"
#include "common/wire/udp.h"
#include "haptic_server/net/admission.h"
#include "haptic_server/net/datagram_paths.h"
#include "haptic_server/net/rate_limit.h"
#include "haptic_server/net/server_host.h"
#include "haptic_server/net/servo_feed.h"
#include "haptic_server/net/upload_budget.h"
#include "haptic_server/scene/scene_service.h"

namespace haptics {

/// Lines about connections in the log, so many a second: a flood of them must not fill the disk.
class ConnectionLog {
 public:
  explicit ConnectionLog(std::function<void(const std::string&)> write) : write_(std::move(write)) {}

  void add(const std::string& line, std::uint64_t now_ns) {
    if (!rate_.allow(now_ns)) {
      ++leftOut_;
      return;
    }
    if (leftOut_ > 0) write_(std::to_string(leftOut_) + " lines about connections left out");
    leftOut_ = 0;
    write_(line);
  }

 private:
  static constexpr double kLinesPerSecond = 5;
  static constexpr double kBurst = 50;

  std::function<void(const std::string&)> write_;
  RateLimit rate_{kLinesPerSecond, kBurst};
  std::uint64_t leftOut_ = 0;
};

/// deformedHash() for clients that ask. It takes milliseconds where much gives, so that it is not computed for each.
class DeformedHashCache {
 public:
  static constexpr std::uint64_t kEvery_ns = 100'000'000;  ///< Longest time that an answer is given again, nanoseconds.

  explicit DeformedHashCache(const SceneService& sceneService) : sceneService_(sceneService) {}

  /// Hash of the newest version with these dents, not older than kEvery_ns.
  [[nodiscard]] std::optional<ContentHash> hashOf(const SceneHistory& scene, std::span<const ObjectDent> dents,
                                                  std::uint64_t now_ns) {
    const std::uint64_t revision = scene.version.revision();
    if (!known_ || known_->revision != revision || now_ns - known_->at_ns >= kEvery_ns) {
      known_ = {revision, now_ns, sceneService_.deformedHash(scene.version, dents)};
    }
    return known_->hash;
  }

 private:
  struct Known {
    std::uint64_t revision, at_ns;
    std::optional<ContentHash> hash;
  };
  const SceneService& sceneService_;
  std::optional<Known> known_;
};

/// State that the connections of a server share. The network thread's, but for the counts, which any thread may read.
struct SharedByConnections {
  SharedByConnections(const std::optional<ServerCredentials>& credentials, SceneService& sceneService_,
                      ServerHost& host_)
      : sceneService(sceneService_),
        host(host_),
        history(sceneService_.history()),
        servo(host_),
        shapes(sceneService_),
        admission(credentials) {}

  void logLine(const std::string& line) { log.add(line, monotonicNow_ns()); }

  SceneService& sceneService;
  ServerHost& host;
  std::shared_ptr<const SceneHistory> history;  ///< The newest.
  ServoFeed servo;
  DeformedHashCache shapes;
  /// Null: there is no such hand.
  [[nodiscard]] HandHost* hand(std::size_t index) { return index == 0 ? &host : host.secondHand(); }
  /// Number of the connection whose client leads the simulated hand, of each hand.
  std::array<std::optional<std::uint64_t>, kMaxLedHands> handLeader;
  struct WrenchGiver {
    std::uint64_t connection;  ///< Its number.
    std::uint64_t until_ns;    ///< From then on another may be.
  };
  /// Whose client adds to the force of each hand.
  std::array<std::optional<WrenchGiver>, kMaxLedHands> wrenchGiver;
  Admission admission;
  UploadBudget uploads{Admission::kUploads_bytes, admission.uploadsOfToken_bytes()};
  std::unique_ptr<DatagramSocket> datagrams;  ///< Null: no telemetry by datagram.
  std::function<void(std::uint64_t connection, const v1::HandTarget& target)> onTarget;  ///< By datagram.
  DatagramPaths paths{[this](std::span<const char> bytes, const Endpoint& to) {
                        if (datagrams) datagrams->send(bytes, to);
                      },
                      [this](std::uint64_t connection, const v1::HandTarget& target) {
                        if (onTarget) onTarget(connection, target);
                      }};
  ConnectionLog log{[this](const std::string& line) { host.log(line); }};
  std::atomic<std::uint32_t> clients{0};             ///< Welcomed and connected.
  std::atomic<std::uint64_t> refusedConnections{0};  ///< Turned away, or gone before they were welcomed.
};

}  // namespace haptics
