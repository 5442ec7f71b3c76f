// haptic_ros2: publishes a haptic_server's session to ROS 2, by DDS.

#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>

#include "common/log/log.h"
#include "graphics_client/mirror/client_program.h"
#include "graphics_client/ros2/bridge.h"

namespace {

using haptics::Result;

const char* const kExamples = R"(
Examples:
  haptic_ros2
      publishes the server on this machine, to nodes on this machine
  haptic_ros2 --connect 192.168.1.20:7654 --interface eth0 --domain 7 --crtk
      a server elsewhere, for the nodes of domain 7 behind eth0, by CRTK's names

)";

/// Of the nodes that are started in the same shell.
Result<int> usualDomain() {
  const char* const given = std::getenv("ROS_DOMAIN_ID");
  if (given == nullptr || *given == '\0') return 0;
  const std::string_view text = given;
  int domain = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
  if (error != std::errc() || end != text.data() + text.size() || domain < 0 ||
      domain > static_cast<int>(haptics::dds::Participant::kMaxDomain))
    return haptics::refused("ROS_DOMAIN_ID", "it has to be a number from 0 to 232");
  return domain;
}

/// @param domain  -1: not given.
Result<void> complete(haptics::BridgeOptions& options, int domain, bool isBestEffort) {
  const Result<int> known = domain < 0 ? usualDomain() : domain;
  if (!known) return tl::unexpected(known.error());
  options.domain = static_cast<std::uint32_t>(*known);
  if (const char* const settings = std::getenv("CYCLONEDDS_URI"); settings != nullptr && options.interface.empty())
    options.ddsSettings = settings;
  if (isBestEffort) options.reliability = haptics::dds::Reliability::kBestEffort;
  return haptics::checkNamespace(options.name);
}

}  // namespace

int main(int argc, char** argv) {
  haptics::BridgeOptions options;
  int domain = -1;
  bool isBestEffort = false;
  haptics::BridgeProgram app(
      "haptic_ros2", "Publishes every tick of a haptic_server to ROS 2, and moves its objects from there.", kExamples);
  haptics::addServerOptions(app, options.server, options.credentials,
                            "viewer.credentials, or editor.credentials to move objects");
  app.option("--domain", domain, "DDS domain; by default that of ROS_DOMAIN_ID, else 0")
      .range(0, static_cast<int>(haptics::dds::Participant::kMaxDomain));
  app.option("--interface", options.interface,
             "Network interface to speak on, by name or address; by default that of CYCLONEDDS_URI, else this machine "
             "alone")
      .typeName("NAME");
  app.option("--namespace", options.name, "Of the topics").typeName("NAME").showDefault();
  app.flag("--crtk", options.crtkNames, "CRTK's names: measured_cp, measured_cv, measured_cf for pose, twist, wrench");
  app.flag("--best-effort", isBestEffort, "Ticks as sensor data: those that the network loses are not sent again");
  return app.run(
      argc, argv, [&] { return complete(options, domain, isBestEffort); },
      [&](const auto& stop) { return haptics::runBridge(options, stop, haptics::logInfo); });
}
