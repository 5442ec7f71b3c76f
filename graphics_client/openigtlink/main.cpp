// haptic_igtl: speaks OpenIGTLink to 3D Slicer, PLUS and others, for a haptic_server's session.

#include <string>
#include <utility>

#include "common/log/log.h"
#include "graphics_client/mirror/client_program.h"
#include "graphics_client/openigtlink/bridge.h"

namespace {

const char* const kExamples = R"(
Examples:
  haptic_igtl
      sends the session of the server on this machine, to programs on this machine that connect to port 18944
  haptic_igtl --connect 192.168.1.20:7654 --rate 200 --listen 0.0.0.0:18944
      a server elsewhere, for all who reach this machine: nobody is asked for a password

)";

}  // namespace

int main(int argc, char** argv) {
  haptics::igtl::BridgeOptions options;
  options.say = haptics::logInfo;
  std::string listen = "127.0.0.1:18944";
  haptics::BridgeProgram app(
      "haptic_igtl",
      "Sends a haptic_server's session to programs that speak OpenIGTLink, and moves its objects from there.",
      kExamples);
  haptics::addServerOptions(app, options.server, options.credentials,
                            "viewer.credentials, or editor.credentials to move objects");
  app.option("--listen", listen, "Where programs connect").typeName("HOST:PORT").showDefault();
  app.option("--rate", options.rate_Hz, "Messages of each kind, a second").range(1, 1000).showDefault();
  const auto prepare = [&]() -> haptics::Result<void> {
    auto endpoint = haptics::parseEndpoint(listen);
    if (!endpoint) return tl::unexpected(std::move(endpoint).error().within("--listen: "));
    options.listen = *std::move(endpoint);
    return {};
  };
  return app.run(argc, argv, prepare, [&](const auto& stop) { return haptics::igtl::runBridge(options, stop); });
}
