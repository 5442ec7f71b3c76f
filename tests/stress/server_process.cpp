#include "tests/stress/server_process.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "tests/stress/run_files.h"

namespace haptics::stress {

using Json = nlohmann::ordered_json;

ServerProcess::ServerProcess(const Network& network, const std::filesystem::path& out, const std::string& sceneText,
                             const std::vector<std::string>& options)
    : out_(out) {
  start(network.serverHost() + ":0", sceneText, options, [&network] { network.enterServerSide(); });
}

ServerProcess::ServerProcess(const std::filesystem::path& out, const std::string& sceneText,
                             const std::vector<std::string>& options, std::uint16_t port)
    : out_(out) {
  start("127.0.0.1:" + std::to_string(port), sceneText, options, [] {});
}

void ServerProcess::start(const std::string& listen, const std::string& sceneText,
                          const std::vector<std::string>& options, const std::function<void()>& prepare) {
  const auto scene = out_ / "stress.scene", log = out_ / "server.log";
  std::filesystem::remove(log);  // of a server before
  std::ofstream(scene) << sceneText;
  std::vector<std::string> command{(self().parent_path() / "haptic_server").string(),
                                   "--scene",
                                   scene.string(),
                                   "--summary",
                                   (out_ / "server.json").string(),
                                   "--allow-insecure-lan",
                                   "--listen",
                                   listen};
  command.insert(command.end(), options.begin(), options.end());
  process_ = Child(command, log, prepare);
  std::optional<std::string> where;
  waitUntil(kPatience_s, "the server listens: see " + log.string(),
            [&] { return (where = lineOf(log, "listening on ")) || !process_.alive(); });
  if (!where) throw std::runtime_error("the server does not start: see " + log.string());
  port_ = static_cast<std::uint16_t>(std::stoi(where->substr(where->rfind(':') + 1)));
}

void ServerProcess::checkAlive() {
  if (!process_.alive()) throw std::runtime_error("the server has ended by itself: see its log");
}

Json ServerProcess::summary() const { return readJson(out_ / "server.json"); }

std::unique_ptr<Network> makeNetwork(const RunPlan& plan, bool relay, const std::filesystem::path& out) {
  std::filesystem::create_directories(out);
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    if (entry.path().extension() == ".log" || entry.path().extension() == ".json") std::filesystem::remove(entry);
  }
  auto network = relay ? nullptr : makeNamespaces(plan);
  return network ? std::move(network) : makeRelay(plan);
}

Json headOf(const RunPlan& plan, const Network& network) {
  return {{"network", network.kind()}, {"rtt_ms", plan.rtt_ms},   {"jitter_ms", plan.jitter_ms},
          {"loss_pct", plan.loss_pct}, {"seconds", plan.seconds}, {"seed", plan.seed}};
}

void conclude(Json& report, Network& network, Json holds) {
  const NetworkCounts counts = network.counts();
  report["packets"] = counts.packets;
  report["packets_lost"] = counts.lost;
  report["packets_late_by_this_machine_ms_p99"] = counts.late_ms;
  report["pass"] = std::ranges::all_of(holds, [](const Json& one) { return one.get<bool>(); });
  report["holds"] = std::move(holds);
}

}  // namespace haptics::stress
