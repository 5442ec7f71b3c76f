// haptic_ros2: publishes a haptic_server's session to ROS 2, by DDS.

#include <atomic>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include "common/command_line/command_line.h"
#include "common/log/log.h"
#include "common/text/printable.h"
#include "graphics_client/ros2/bridge.h"

namespace {

using haptics::Error;
using haptics::Result;

enum ExitCode { kDone = 0, kFailed = 1, kBadUsage = 2 };

const char* const kExamples = R"(
Examples:
  haptic_ros2
      publishes the server on this machine, to nodes on this machine
  haptic_ros2 --connect 192.168.1.20:7654 --interface eth0 --domain 7 --crtk
      a server elsewhere, for the nodes of domain 7 behind eth0, by CRTK's names

SIGINT and SIGTERM end it. Exit status: 0 done, 1 somebody has to change something first, 2 wrong usage.)";

struct Arguments {
  std::string connect = "127.0.0.1:7654";
  std::string credentials, interface, name = "/haptics";
  int domain = 0;
  bool crtk = false, bestEffort = false;
};

std::atomic<bool> stopRequested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

int fail(const Error& error, ExitCode code) {
  std::fprintf(stderr, "haptic_ros2: %s\n", haptics::printable(error.text()).c_str());
  return code;
}

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

Result<haptics::BridgeOptions> optionsFrom(const Arguments& arguments) {
  haptics::BridgeOptions options;
  auto server = haptics::parseEndpoint(arguments.connect);
  if (!server) return tl::unexpected(std::move(server).error().within("--connect: "));
  options.server = *std::move(server);
  if (!arguments.credentials.empty()) {
    auto read = haptics::readClientCredentials(arguments.credentials);
    if (!read) return tl::unexpected(std::move(read).error().within("--credentials: "));
    options.credentials = *std::move(read);
  }
  if (auto checked = haptics::checkNamespace(arguments.name); !checked)
    return tl::unexpected(std::move(checked).error());
  options.name = arguments.name;
  options.domain = static_cast<std::uint32_t>(arguments.domain);
  options.interface = arguments.interface;
  if (const char* const settings = std::getenv("CYCLONEDDS_URI"); settings != nullptr && options.interface.empty())
    options.ddsSettings = settings;
  options.crtkNames = arguments.crtk;
  if (arguments.bestEffort) options.reliability = haptics::dds::Reliability::kBestEffort;
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  haptics::logTo(stderr);
  Arguments arguments;
  const auto domain = usualDomain();
  if (!domain) return fail(domain.error(), kBadUsage);
  arguments.domain = *domain;
  haptics::CommandLine app("Publishes every tick of a haptic_server to ROS 2, and moves its objects from there.",
                           "haptic_ros2");
  app.version("haptic_ros2 " HAPTICS_VERSION);
  app.footer(kExamples);
  app.option("--connect", arguments.connect, "The server").typeName("HOST:PORT").showDefault();
  app.option("--credentials", arguments.credentials,
             "Of a server that has some: its viewer.credentials, or editor.credentials to move objects")
      .typeName("FILE");
  app.option("--domain", arguments.domain, "DDS domain; by default that of ROS_DOMAIN_ID, else 0")
      .range(0, static_cast<int>(haptics::dds::Participant::kMaxDomain));
  app.option("--interface", arguments.interface,
             "Network interface to speak on, by name or address; by default that of CYCLONEDDS_URI, else this machine "
             "alone")
      .typeName("NAME");
  app.option("--namespace", arguments.name, "Of the topics").typeName("NAME").showDefault();
  app.flag("--crtk", arguments.crtk, "CRTK's names: measured_cp, measured_cv, measured_cf for pose, twist, wrench");
  app.flag("--best-effort", arguments.bestEffort,
           "Ticks as sensor data: those that the network loses are not sent again");
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? kDone : kBadUsage;
  struct sigaction action = {};
  action.sa_handler = [](int) { stopRequested = true; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  const auto options = optionsFrom(arguments);
  if (!options) return fail(options.error(), kBadUsage);
  try {
    const auto done = haptics::runBridge(*options, stopRequested, haptics::logInfo);
    return done ? kDone : fail(done.error(), kFailed);
  } catch (const std::exception& error) {
    return fail({"", error.what()}, kFailed);
  }
}
