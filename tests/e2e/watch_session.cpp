// Holds a session that haptic_relay publishes, as graphics_client does, without a picture: many of it fit a small machine.
//
//   watch_session URL NAME SUMMARY [CREDENTIALS]     until SIGTERM

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "common/telemetry/body_json.h"
#include "graphics_client/audience/audience_link.h"

namespace {

using haptics::MirrorView;

std::atomic<bool> stopRequested{false};

void announce(const MirrorView& view, std::string& said) {
  if (view.epoch == 0) return;
  const std::string line = "scene revision " + std::to_string(view.scene->revision()) + " root " +
                           view.scene->root().hex() + (view.hashesEqual ? " equal" : " not equal");
  if (line == said) return;
  said = line;
  std::puts(line.c_str());
  std::fflush(stdout);
}

nlohmann::json summaryOf(const MirrorView& view) {
  nlohmann::json summary = {{"client_bodies", nlohmann::json::array()},
                            {"client_dents", view.dents.size()},
                            {"resyncs", view.resyncs},
                            {"state_resets", view.stateResets},
                            {"connections", view.connections},
                            {"may_edit", view.mayEdit},
                            {"link", view.linkText}};
  for (const auto& [id, body] : view.bodies)
    summary["client_bodies"].push_back(nlohmann::json::parse(haptics::bodyJson(body).line()));
  return summary;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kNeeded = 4;
  if (argc < kNeeded) return 2;
  std::signal(SIGTERM, [](int) { stopRequested = true; });
  haptics::NatsOptions nats{.url = argv[1], .clientName = "watch_session"};
  if (argc > kNeeded) nats.credentials = haptics::readNatsCredentials(argv[kNeeded]).value();
  const haptics::ServerLink link(
      {.server = {},
       .clientName = "watch_session",
       .connect = haptics::connectThroughNats(nats, haptics::SessionSubjects::of(argv[2]).value(), argv[2])});
  std::string said;
  while (!stopRequested) {
    announce(*link.latest(), said);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::ofstream(argv[3]) << summaryOf(*link.latest());
}
