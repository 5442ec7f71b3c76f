// haptic_igtl: speaks OpenIGTLink to 3D Slicer, PLUS and others, for a haptic_server's session.

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "common/command_line/command_line.h"
#include "common/log/log.h"
#include "common/text/printable.h"
#include "graphics_client/openigtlink/bridge.h"

namespace {

using haptics::Error;
using haptics::Result;
using haptics::igtl::BridgeOptions;

enum ExitCode { kDone = 0, kFailed = 1, kBadUsage = 2 };

const char* const kExamples = R"(
Examples:
  haptic_igtl
      sends the session of the server on this machine, to programs on this machine that connect to port 18944
  haptic_igtl --connect 192.168.1.20:7654 --rate 200 --listen 0.0.0.0:18944
      a server elsewhere, for all who reach this machine: nobody is asked for a password

SIGINT and SIGTERM end it. Exit status: 0 done, 1 somebody has to change something first, 2 wrong usage.)";

struct Arguments {
  std::string connect = "127.0.0.1:7654";
  std::string credentials, listen = "127.0.0.1:18944";
  double rate_Hz = 60;
};

std::atomic<bool> stopRequested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

int fail(const Error& error, ExitCode code) {
  std::fprintf(stderr, "haptic_igtl: %s\n", haptics::printable(error.text()).c_str());
  return code;
}

Result<BridgeOptions> optionsFrom(const Arguments& arguments) {
  BridgeOptions options;
  auto server = haptics::parseEndpoint(arguments.connect);
  if (!server) return tl::unexpected(std::move(server).error().within("--connect: "));
  options.server = *std::move(server);
  auto listen = haptics::parseEndpoint(arguments.listen);
  if (!listen) return tl::unexpected(std::move(listen).error().within("--listen: "));
  options.listen = *std::move(listen);
  if (!arguments.credentials.empty()) {
    auto read = haptics::readClientCredentials(arguments.credentials);
    if (!read) return tl::unexpected(std::move(read).error().within("--credentials: "));
    options.credentials = *std::move(read);
  }
  options.rate_Hz = arguments.rate_Hz;
  options.say = haptics::logInfo;
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  haptics::logTo(stderr);
  Arguments arguments;
  haptics::CommandLine app(
      "Sends a haptic_server's session to programs that speak OpenIGTLink, and moves its objects from there.",
      "haptic_igtl");
  app.version("haptic_igtl " HAPTICS_VERSION);
  app.footer(kExamples);
  app.option("--connect", arguments.connect, "The server").typeName("HOST:PORT").showDefault();
  app.option("--credentials", arguments.credentials,
             "Of a server that has some: its viewer.credentials, or editor.credentials to move objects")
      .typeName("FILE");
  app.option("--listen", arguments.listen, "Where programs connect").typeName("HOST:PORT").showDefault();
  app.option("--rate", arguments.rate_Hz, "Messages of each kind, a second").range(1, 1000).showDefault();
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? kDone : kBadUsage;
  struct sigaction action = {};
  action.sa_handler = [](int) { stopRequested = true; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  const auto options = optionsFrom(arguments);
  if (!options) return fail(options.error(), kBadUsage);
  try {
    const auto done = haptics::igtl::runBridge(*options, stopRequested);
    return done ? kDone : fail(done.error(), kFailed);
  } catch (const std::exception& error) {
    return fail({"", error.what()}, kFailed);
  }
}
