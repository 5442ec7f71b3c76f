#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "common/credentials/credentials.h"
#include "common/error/error.h"
#include "common/wire/endpoint.h"
#include "graphics_client/ros2/dds.h"

namespace haptics {

struct BridgeOptions {
  Endpoint server;
  std::optional<ClientCredentials> credentials{};  ///< Of the server.
  std::uint32_t domain = 0;                        ///< Of DDS; ROS 2's ROS_DOMAIN_ID.
  std::string interface, ddsSettings;              ///< As dds::Participant::join().
  std::string name = "/haptics";                   ///< Namespace of the topics.
  bool crtkNames = false;
  dds::Reliability reliability = dds::Reliability::kReliable;
};

/// Refused: a name that ROS 2 does not take as a namespace.
[[nodiscard]] Result<void> checkNamespace(const std::string& name);

/// Publishes the server's session to ROS 2, and takes objects' poses from there, until `stop` is set; reconnects to the server
/// by itself. Refused: what somebody has to change first.
/// @param say  Gets a line whenever something changes.
[[nodiscard]] Result<void> runBridge(const BridgeOptions& options, const std::atomic<bool>& stop,
                                     const std::function<void(const std::string&)>& say);

}  // namespace haptics
