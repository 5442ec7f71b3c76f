#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/credentials/credentials.h"
#include "common/wire/transport.h"
#include "haptic_server/scene/scene_history.h"
#include "tests/sim/disk.h"
#include "tests/sim/stage.h"

namespace haptics::sim {

/// How the server is doing at the moment.
struct ServerPace {
  double build_ms = 2;                ///< Longest time that the builder takes for one edit.
  double prepare_ms = 20;             ///< Longest time that a worker takes for one.
  double adopt_ms = 10;               ///< Longest time until the servo adopts a scene.
  std::size_t builderQueue = 10'000;  ///< Jobs; above, the server is busy.
  bool handDents = false;             ///< A hand leaves dents in what is plastic.
};

/// The server's process: production sessions, sequencer and mesh library; a builder whose answers take a while, a
/// servo that adopts some milliseconds later, and crashes.
class SimServer {
 public:
  SimServer(Stage& stage, const ServerPace& pace);
  ~SimServer();

  /// With the state that the last one left, if wanted and there is one; else with the start scene in a new epoch.
  void start(bool keepState);
  /// The process is gone, with every connection and all that was not on disk.
  void crash();
  /// The process is to crash while it writes to its disk: `died` is called then, and is to crash it.
  void dieInNextWrite(const std::function<void()>& died);
  /// From now on it asks for a token, and these are the ones that it knows.
  void knowTokens(const std::vector<std::string>& tokens);
  [[nodiscard]] Disk& disk() { return *disk_; }
  [[nodiscard]] bool up() const noexcept { return process_ != nullptr; }
  void accept(std::unique_ptr<Transport> transport);
  [[nodiscard]] std::shared_ptr<const SceneHistory> history() const;
  /// Names of the start scene's objects; they are never removed.
  [[nodiscard]] static const std::vector<std::string>& counters();
  /// The name of each of the start scene's others, from 0.
  [[nodiscard]] static std::string startObject(std::size_t i);

 private:
  struct Process;
  struct Connection;

  Stage& stage_;
  const ServerPace& pace_;
  AssetStore store_;
  std::unique_ptr<Disk> disk_;
  std::optional<ServerCredentials> credentials_;
  std::shared_ptr<Process> process_;
};

}  // namespace haptics::sim
