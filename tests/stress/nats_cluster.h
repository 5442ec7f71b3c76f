#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/stress/child.h"

namespace haptics::stress {

/// NATS servers on loopback, with JetStream; more than one are a cluster. Throws std::runtime_error where nats-server is not
/// there or does not start.
class NatsCluster {
 public:
  NatsCluster(const std::filesystem::path& out, int nodes);

  /// Of all nodes, also of those that were killed.
  [[nodiscard]] std::string urls() const;
  /// Kills the node that leads this stream. @return Its name.
  std::string killLeaderOf(const std::string& stream);

 private:
  struct Node {
    std::string name;
    std::uint16_t port = 0;
    Child process;
  };
  std::vector<Node> nodes_;
};

}  // namespace haptics::stress
