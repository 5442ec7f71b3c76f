#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graphics_client/mirror/server_link.h"
#include "tests/stress/child.h"
#include "tests/stress/network.h"
#include "tests/stress/server_process.h"

namespace haptics::stress {

struct CastOptions {
  std::filesystem::path out = {};
  bool relay = false;  ///< Also where namespaces could be made.
  int viewers = 0;     ///< Every second one has its telemetry by UDP.
};

/// The processes of a run: a server, viewers on the far side of the network, and a link beside the server.
class Cast {
 public:
  /// Starts them, and the plan's clock. Throws std::runtime_error where it cannot.
  Cast(RunPlan& plan, const CastOptions& options, Network& network, const std::string& sceneText,
       const std::vector<std::string>& serverOptions = {});

  [[nodiscard]] ServerProcess& server() { return server_; }
  [[nodiscard]] ServerLink& witness() { return *witness_; }
  /// Another process on the far side: a verb of this program, with the server's address. Its output goes to NAME.log.
  void addClient(const std::string& name, std::vector<std::string> command);
  [[nodiscard]] bool says(const std::string& name, const std::string& line) const;
  /// Throws std::runtime_error where it takes too long.
  void awaitViewers(const std::function<bool()>& andAlso);
  /// Stops everything in order.
  /// @param ofServer  What the report takes over from the server's summary.
  [[nodiscard]] nlohmann::ordered_json finish(std::initializer_list<const char*> ofServer);

 private:
  [[nodiscard]] static std::string viewer(int number) { return "viewer_" + std::to_string(number); }

  const CastOptions& options_;
  Network& network_;
  ServerProcess server_;
  std::string address_;
  std::vector<Child> clients_;  // viewers first
  std::unique_ptr<ServerLink> witness_;
};

}  // namespace haptics::stress
