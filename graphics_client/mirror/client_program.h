#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "common/command_line/command_line.h"
#include "common/credentials/credentials.h"
#include "common/wire/endpoint.h"

namespace haptics {

/// --connect and --credentials: the server that a program speaks to.
/// @param which  Of its credentials, for the help.
void addServerOptions(Command& app, Endpoint& server, std::optional<ClientCredentials>& credentials,
                      const std::string& which);

/// The command line of a program that brings a haptic_server's session to others.
class BridgeProgram : public CommandLine {
 public:
  BridgeProgram(const std::string& name, const std::string& about, const std::string& examples);

  /// Serves until SIGINT or SIGTERM; once in a process.
  /// @param prepare  Refused: what is wrong with the options.
  /// @param endWithin_s  Longest time after a signal; 0: as long as it takes.
  /// @return The exit status.
  int run(int argc, char** argv, const std::function<Result<void>()>& prepare,
          const std::function<Result<void>(const std::atomic<bool>& stop)>& serve, unsigned endWithin_s = 0);

 private:
  std::string name_;
};

}  // namespace haptics
