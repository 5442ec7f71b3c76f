#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "graphics_client/mirror/server_link.h"
#include "tests/stress/stress_scene.h"
#include "tests/stress/tapped_tcp.h"

namespace haptics::stress {

/// Beside the server, on its side of the bad network: writes down every commit, and how punctual the servo is.
class Auditor {
 public:
  struct Commit {
    std::uint64_t time_ns = 0, revision = 0;
    ContentHash root;
    std::vector<std::pair<std::string, EditName>> marks;  ///< Of the clients whose edits this is; one of one client.
    std::optional<std::uint64_t> counter;
  };
  struct Pulse {  ///< Of the servo.
    std::uint64_t time_ns = 0, tick = 0, missedTicks = 0;
    std::uint64_t life = 0;  ///< Of the server.
    std::uint64_t device_ns = 0;
  };

  /// `life` counts the server's lives. To be made in a thread on the server's side.
  Auditor(Endpoint server, std::function<std::uint64_t()> life);

  [[nodiscard]] std::shared_ptr<const MirrorView> latest() const { return link_->latest(); }
  [[nodiscard]] std::vector<Commit> commits() const;
  [[nodiscard]] std::vector<Pulse> pulses() const;
  [[nodiscard]] std::uint64_t gaps() const;

 private:
  void take(const v1::Envelope& envelope);

  std::function<std::uint64_t()> life_;
  CommitOrder order_;
  mutable std::mutex mutex_;  // guards what follows
  std::vector<Commit> commits_;
  std::vector<Pulse> pulses_;
  std::uint64_t gaps_ = 0;
  std::unique_ptr<ServerLink> link_;  // last: its thread calls take()
};

}  // namespace haptics::stress
