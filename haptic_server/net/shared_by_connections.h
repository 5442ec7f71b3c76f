#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "common/clock/monotonic.h"
#include "common/credentials/credentials.h"
#include "common/wire/udp.h"
#include "haptic_server/net/admission.h"
#include "haptic_server/net/connection_log.h"
#include "haptic_server/net/datagram_paths.h"
#include "haptic_server/net/deformed_hash_cache.h"
#include "haptic_server/net/server_host.h"
#include "haptic_server/net/servo_feed.h"
#include "haptic_server/net/upload_budget.h"
#include "haptic_server/scene/scene_service.h"

namespace haptics {

/// What the connections of a server share. The network thread's, but for the counts, which any thread may read.
struct SharedByConnections {
  SharedByConnections(const std::optional<ServerCredentials>& credentials, SceneService& sceneService_,
                      ServerHost& host_)
      : sceneService(sceneService_),
        host(host_),
        history(sceneService_.history()),
        servo(host_),
        shapes(sceneService_),
        admission(credentials) {}
  SharedByConnections(const SharedByConnections&) = delete;
  SharedByConnections& operator=(const SharedByConnections&) = delete;

  void logLine(const std::string& line) { log.add(line, monotonicNow_ns()); }

  SceneService& sceneService;
  ServerHost& host;
  std::shared_ptr<const SceneHistory> history;  ///< The newest.
  ServoFeed servo;
  DeformedHashCache shapes;
  std::optional<std::uint64_t> handLeader;  ///< Number of the connection whose client leads the simulated hand.
  Admission admission;
  UploadBudget uploads{Admission::kUploads_bytes, admission.uploadsOfToken_bytes()};
  std::unique_ptr<DatagramSocket> datagrams;  ///< Null: no telemetry by datagram.
  DatagramPaths paths{[this](std::span<const char> bytes, const Endpoint& to) {
    if (datagrams) datagrams->send(bytes, to);
  }};
  ConnectionLog log{[this](const std::string& line) { host.log(line); }};
  std::atomic<std::uint32_t> clients{0};             ///< Welcomed and connected.
  std::atomic<std::uint64_t> refusedConnections{0};  ///< Turned away, or gone before they were welcomed.
};

}  // namespace haptics
