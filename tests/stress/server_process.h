#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/stress/child.h"
#include "tests/stress/network.h"

namespace haptics::stress {

/// haptic_server on the server's side of a network, with its files in a folder.
class ServerProcess {
 public:
  static constexpr double kPatience_s = 30;

  /// Until it listens. Throws std::runtime_error where it does not.
  ServerProcess(const Network& network, const std::filesystem::path& out, const std::string& sceneText,
                const std::vector<std::string>& options = {});
  /// On loopback; port 0: any.
  ServerProcess(const std::filesystem::path& out, const std::string& sceneText, const std::vector<std::string>& options,
                std::uint16_t port);

  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
  /// Throws std::runtime_error where it has ended by itself.
  void checkAlive();
  /// @return Whether it ended well.
  [[nodiscard]] bool stop() { return process_.stop(kPatience_s) == 0; }
  /// Once it has ended.
  [[nodiscard]] nlohmann::ordered_json summary() const;

 private:
  void start(const std::string& listen, const std::string& sceneText, const std::vector<std::string>& options,
             const std::function<void()>& prepare);

  std::filesystem::path out_;
  Child process_;
  std::uint16_t port_ = 0;
};

/// The network of a run, in a folder that holds no results of an earlier one.
[[nodiscard]] std::unique_ptr<Network> makeNetwork(const RunPlan& plan, bool relay, const std::filesystem::path& out);
/// What a report begins with.
[[nodiscard]] nlohmann::ordered_json headOf(const RunPlan& plan, const Network& network);
/// Adds the network's counts, what has to hold, and whether all of it does.
void conclude(nlohmann::ordered_json& report, Network& network, nlohmann::ordered_json holds);

}  // namespace haptics::stress
