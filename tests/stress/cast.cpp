#include "tests/stress/cast.h"

#include <csignal>
#include <thread>

#include "tests/stress/run_files.h"

namespace haptics::stress {

using Json = nlohmann::ordered_json;

Cast::Cast(RunPlan& plan, const CastOptions& options, Network& network, const std::string& sceneText,
           const std::vector<std::string>& serverOptions)
    : options_(options),
      network_(network),
      server_(network, options.out, sceneText, serverOptions),
      address_(network.clientAddress(server_.port())) {
  plan.began_ns = monotonicNow_ns();
  network_.start();
  for (int number = 0; number < options.viewers; ++number) {
    std::vector<std::string> command{"look", "--number", std::to_string(number), "--summary",
                                     (options.out / (viewer(number) + ".json")).string()};
    if (number % 2 == 0) command.emplace_back("--udp");
    addClient(viewer(number), std::move(command));
  }
  std::thread([this] {
    network_.enterServerSide();
    witness_ = std::make_unique<ServerLink>(ServerLink::Options{
        .server = {network_.serverHost(), server_.port()}, .clientName = "witness", .telemetryRate_Hz = 100});
  }).join();
}

void Cast::addClient(const std::string& name, std::vector<std::string> command) {
  command.insert(command.begin(), self().string());
  command.insert(command.end(), {"--connect", address_});
  clients_.emplace_back(command, options_.out / (name + ".log"), [this] { network_.enterClientSide(); });
}

bool Cast::says(const std::string& name, const std::string& line) const {
  return lineOf(options_.out / (name + ".log"), line).has_value();
}

void Cast::awaitViewers(const std::function<bool()>& andAlso) {
  constexpr double kJoining_s = 120;  // until meshes are through the bad line
  waitUntil(kJoining_s, "every viewer holds the scene", [&] {
    for (int number = 0; number < options_.viewers; ++number) {
      if (!says(viewer(number), "holds the scene")) return false;
    }
    return andAlso();
  });
}

Json Cast::finish(std::initializer_list<const char*> ofServer) {
  constexpr double kPatience_s = 30;
  const auto others = clients_.begin() + options_.viewers;
  for (const auto& [first, last] : {std::pair{clients_.begin(), others}, std::pair{others, clients_.end()}}) {
    for (auto child = first; child != last; ++child) child->signal(SIGTERM);
    for (auto child = first; child != last; ++child) child->stop(kPatience_s);
  }
  witness_.reset();
  Json report;
  report["server_ended_well"] = server_.stop();
  const Json server = server_.summary();
  for (const char* key : ofServer) report["server"][key] = server.at(key);
  for (int number = 0; number < options_.viewers; ++number)
    report["viewers"].push_back(readJson(options_.out / (viewer(number) + ".json")));
  return report;
}

}  // namespace haptics::stress
