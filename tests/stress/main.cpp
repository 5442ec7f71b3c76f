// haptic_stress: real processes on a bad network, editing, being killed, stopped and starved; and what is left of them.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <tuple>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/command_line/command_line.h"
#include "common/wire/endpoint.h"
#include "tests/stress/audience_run.h"
#include "tests/stress/client.h"
#include "tests/stress/dribbler.h"
#include "tests/stress/picture.h"
#include "tests/stress/pinch_run.h"
#include "tests/stress/report.h"
#include "tests/stress/run.h"
#include "tests/stress/ticks_run.h"
#include "tests/stress/touch_run.h"
#include "tests/stress/touch_viewer.h"
#include "tests/stress/watchers.h"

namespace {

using namespace haptics;
using namespace haptics::stress;

constexpr const char* kExamples = R"(
Examples:
  haptic_stress --clients 8 --rtt-ms 200 --jitter-ms 25 --loss-pct 5 --cut-every 10 --cut-ms 300 --seconds 600 --seed 1 --out out
  haptic_stress --seconds 60 --out out
  haptic_stress --relay --seconds 10 --clients 3 --no-viewer --out out
  haptic_stress pinch --rtt-ms 200 --loss-pct 5 --seconds 60 --out out
  haptic_stress ticks --rtt-ms 200 --loss-pct 5 --seconds 600 --out out
  haptic_stress touch --viewers 4 --rtt-ms 200 --loss-pct 5 --seconds 300 --out out
  haptic_stress programs --loss-pct 5 --server-side 'haptic_server --listen 10.99.0.1:7654 --allow-insecure-lan' \
    --client-side 'hapticctl --connect 10.99.0.1:7654 watch --seconds 10' --out out
  haptic_stress audience --watchers 500 --nodes 3 --seconds 300 --scene deploy/scenes/demo.scene --out out

As root the processes are in two network namespaces, joined by TUN devices and a forwarder of packets; else, and with
--relay, TCP and UDP go through a relay. Writes DIR/stress.json, stress.png and stress.svg; touch writes DIR/touch.json, pinch
DIR/pinch.json, ticks DIR/ticks.json. audience is all on loopback, and writes DIR/audience.json. programs needs the
namespaces; in both the device is "haptics", the servers' side is 10.99.0.1, and what is printed goes to DIR/*_side.log.
Exit status: 0 everything holds, 1 something does not (the JSON says what), 2 wrong usage.)";

/// Those without which some verbs have defaults of their own.
struct PlanOptions {
  Option cut, edits;
};

PlanOptions addPlan(Command& app, RunPlan& plan) {
  app.option("--clients", plan.clients, "That edit").range(1, 32).showDefault();
  app.option("--rtt-ms", plan.rtt_ms, "Round trip").range(0.0, 2000.0).showDefault();
  app.option("--jitter-ms", plan.jitter_ms, "Standard deviation, each way").range(0.0, 500.0).showDefault();
  app.option("--loss-pct", plan.loss_pct, "Packets lost, each way").range(0.0, 50.0).showDefault();
  app.option("--cut-every", plan.cutEvery_s, "Seconds").range(0.1, 1e4).showDefault();
  const Option cut = app.option("--cut-ms", plan.cut_ms, "Nothing passes for so long").range(0.0, 1e5).showDefault();
  app.option("--seconds", plan.seconds, "Of quiet and attack in turns").range(4.0, 1e6).showDefault();
  const Option edits = app.option("--edits", plan.edits_Hz, "A second, of each client").range(0.1, 150.0).showDefault();
  app.option("--seed", plan.seed).showDefault();
  app.option("--began", plan.began_ns).hidden();  // for the clients that this program starts
  return {cut, edits};
}

Endpoint endpointOrThrow(const std::string& text) {
  const auto endpoint = parseEndpoint(text);
  if (!endpoint) throw std::runtime_error(endpoint.error().text());
  return *endpoint;
}

/// @return The exit code.
int conclude(const nlohmann::ordered_json& report, const std::filesystem::path& out, const char* verb) {
  const std::string text = report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::ofstream(out / (std::string(verb) + ".json")) << text << '\n';
  std::printf("%s\n", text.c_str());
  return report.at("pass").get<bool>() ? 0 : 1;
}

struct Programs {
  std::vector<std::string> serverSide;
  std::string clientSide;
};

/// The report. Throws std::runtime_error where it cannot run.
nlohmann::ordered_json runPrograms(RunPlan plan, const Programs& programs, const std::filesystem::path& out) {
  std::filesystem::create_directories(out);
  for (const char* log : {"server_side.log", "client_side.log"}) std::filesystem::remove(out / log);  // of a run before
  const auto network = makeNamespaces(plan);
  if (!network) throw std::runtime_error("programs: only in network namespaces, as root");
  plan.began_ns = monotonicNow_ns();
  network->start();
  const auto start = [&](const std::string& program, const char* log, void (Network::*enter)() const) {
    return Child({"/bin/sh", "-c", "exec " + program}, out / log, [&] { ((*network).*enter)(); });
  };
  std::vector<Child> servers;
  for (const std::string& program : programs.serverSide)
    servers.push_back(start(program, "server_side.log", &Network::enterServerSide));
  const int code = start(programs.clientSide, "client_side.log", &Network::enterClientSide).wait();
  plan.seconds = plan.secondsAt(monotonicNow_ns());
  auto report = headOf(plan, *network);
  const bool serversRun = std::ranges::all_of(servers, [](Child& server) { return server.alive(); });
  constexpr double kPatience_s = 30;
  for (Child& server : servers) server.stop(kPatience_s);
  conclude(report, *network, {{"servers_run", serversRun}, {"client_ended_well", code == 0}});
  return report;
}

int stressed(const RunPlan& plan, const RunOptions& options) {
  const RunResult result = run(plan, options);
  const int code = conclude(makeReport(result), options.out, "stress");
  try {
    drawPicture(result, options.out);
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "haptic_stress: no picture: %s\n", error.what());
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  RunPlan plan;
  RunOptions options;
  ClientOptions client;
  CastOptions pinch{.viewers = 2}, touch{.viewers = 4}, ticks;
  TouchViewerOptions viewer;
  HandLeaderOptions leader;
  AudienceRunOptions audience;
  WatchersOptions watchers;
  Programs programs;
  std::string address, journal, summary;
  bool noViewer = false, viewOnly = false;
  CommandLine app("Real processes on a bad network, editing, being killed and stopped: what is left of them",
                  "haptic_stress");
  app.footer(kExamples);
  app.takeOptionsAfterVerbs();
  const PlanOptions planOptions = addPlan(app, plan);
  app.option("--out", options.out, "Where results and journals go").typeName("DIR").showDefault("out");
  app.flag("--relay", options.relay, "No network namespaces, even as root");
  app.flag("--no-viewer", noViewer, "Without the real graphics_client");
  Command asClient = app.verb("client").hidden();
  Command asDribbler = app.verb("dribble").hidden();
  Command asViewer = app.verb("look").hidden();
  Command asLeader = app.verb("lead").hidden();
  for (Command verb : {asClient, asDribbler, asViewer, asLeader}) verb.option("--connect", address);
  asClient.option("--number", client.number);
  asClient.option("--life", client.life);
  asClient.option("--journal", journal);
  asClient.flag("--udp", client.datagrams);
  asClient.flag("--view", viewOnly);
  asViewer.option("--number", viewer.number);
  asViewer.option("--summary", summary);
  asViewer.flag("--udp", viewer.datagrams);
  asLeader.option("--hand", leader.hand);
  asLeader.option("--from", leader.began_ns);
  Command asWatchers = app.verb("watch").hidden();
  asWatchers.option("--nats", watchers.nats);
  asWatchers.option("--session", watchers.session);
  asWatchers.option("--count", watchers.count);
  asWatchers.option("--viewers", watchers.viewers);
  asWatchers.option("--summary", summary);
  Command asAudience = app.verb(
      "audience", "A session is published to many: does the servo notice, are samples young, do all hold the same?");
  asAudience.option("--watchers", audience.watchers, "That hold the session").range(1, 4000).showDefault();
  asAudience.option("--viewers", audience.viewers, "Of the watchers, those that hold all assets as well")
      .range(0, 100)
      .showDefault();
  asAudience.option("--nodes", audience.nodes, "NATS servers; of three the one that leads the stream is killed")
      .range(1, 5)
      .showDefault();
  asAudience.option("--kills", audience.kills, "Of the relay").range(0, 1000).showDefault();
  asAudience.option("--scene", audience.scene, "That is published").required().existingFile();
  Command asPinch = app.verb(
      "pinch", "Two clients lead a hand each, which pinch a brick and lift it: is it held, and seen where it is held?");
  asPinch.option("--viewers", pinch.viewers, "That look on").range(1, 32).showDefault();
  Command asPrograms =
      app.verb("programs", "Programs of yours on both sides, until the client ends: does it end well?");
  asPrograms.option("--server-side", programs.serverSide, "Command, told to end at the end; one each time");
  asPrograms.option("--client-side", programs.clientSide, "Command; its end is that of the run").required();
  Command asTicks = app.verb("ticks", "A client has every tick: is each there, or named as missing?");
  Command asTouch = app.verb(
      "touch",
      "Bodies are pushed and soft objects dented: do viewers see contacts where they are, and the same shapes?");
  asTouch.option("--viewers", touch.viewers, "That look on").range(1, 32).showDefault();
  if (const auto code = app.parse(argc, argv)) return *code == 0 ? 0 : 2;
  try {
    if (asDribbler.given()) runDribbler(endpointOrThrow(address));
    if (asClient.given()) {
      client.server = endpointOrThrow(address);
      client.journal = journal;
      client.edits = !viewOnly;
      runClient(plan, client);
      return 0;
    }
    if (asViewer.given()) {
      viewer.server = endpointOrThrow(address);
      viewer.summary = summary;
      runTouchViewer(viewer);
      return 0;
    }
    if (asWatchers.given()) {
      watchers.summary = summary;
      runWatchers(watchers);
      return 0;
    }
    if (asLeader.given()) {
      leader.server = endpointOrThrow(address);
      runHandLeader(leader);
      return 0;
    }
    if (options.out.empty()) options.out = "out";
    options.out = std::filesystem::absolute(options.out);
    if (asAudience.given()) {
      audience.out = options.out;
      if (!planOptions.edits.given()) plan.edits_Hz = 2;
      return conclude(runAudience(plan, audience), options.out, "audience");
    }
    if (asPrograms.given()) {
      if (!planOptions.cut.given()) plan.cut_ms = 0;
      return conclude(runPrograms(plan, programs, options.out), options.out, "programs");
    }
    for (const auto& [verb, cast, play, name] : {std::tuple{asPinch, &pinch, &runPinched, "pinch"},
                                                 {asTicks, &ticks, &runTicks, "ticks"},
                                                 {asTouch, &touch, &runTouched, "touch"}}) {
      if (!verb.given()) continue;
      cast->out = options.out;
      cast->relay = options.relay;
      if (!planOptions.cut.given()) plan.cut_ms = 0;
      return conclude(play(plan, *cast), options.out, name);
    }
    options.viewer = !noViewer;
    return stressed(plan, options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_stress: %s\n", error.what());
    return 1;
  }
}
