// haptic_stress: real processes on a bad network, editing, being killed, stopped and starved; and what is left of them.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

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
  haptic_stress audience --watchers 500 --nodes 3 --seconds 300 --scene deploy/scenes/demo.scene --out out

As root the processes are in two network namespaces, joined by TUN devices and a forwarder of packets; else, and with
--relay, TCP and UDP go through a relay. Writes DIR/stress.json, stress.png and stress.svg; touch writes DIR/touch.json, pinch
DIR/pinch.json, ticks DIR/ticks.json. audience is all on loopback, and writes DIR/audience.json.
Exit status: 0 everything holds, 1 something does not (the JSON says what), 2 wrong usage.)";

void addPlan(CLI::App& app, RunPlan& plan) {
  app.add_option("--clients", plan.clients, "That edit")->check(CLI::Range(1, 32))->capture_default_str();
  app.add_option("--rtt-ms", plan.rtt_ms, "Round trip")->check(CLI::Range(0.0, 2000.0))->capture_default_str();
  app.add_option("--jitter-ms", plan.jitter_ms, "Standard deviation, each way")
      ->check(CLI::Range(0.0, 500.0))
      ->capture_default_str();
  app.add_option("--loss-pct", plan.loss_pct, "Packets lost, each way")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--cut-every", plan.cutEvery_s, "Seconds")->check(CLI::Range(0.1, 1e4))->capture_default_str();
  app.add_option("--cut-ms", plan.cut_ms, "Nothing passes for so long")
      ->check(CLI::Range(0.0, 1e5))
      ->capture_default_str();
  app.add_option("--seconds", plan.seconds, "Of quiet and attack in turns")
      ->check(CLI::Range(4.0, 1e6))
      ->capture_default_str();
  app.add_option("--edits", plan.edits_Hz, "A second, of each client")
      ->check(CLI::Range(0.1, 150.0))
      ->capture_default_str();
  app.add_option("--seed", plan.seed)->capture_default_str();
  app.add_option("--began", plan.began_ns)->group("");  // for the clients that this program starts
}

Endpoint endpointOrThrow(const std::string& text) {
  const auto endpoint = parseEndpoint(text);
  if (!endpoint) throw std::runtime_error(endpoint.error().text());
  return *endpoint;
}

int stressed(const RunPlan& plan, const RunOptions& options) {
  const RunResult result = run(plan, options);
  const auto report = makeReport(result);
  std::ofstream(options.out / "stress.json") << report.dump(2) << '\n';
  if (const auto drawn = drawPicture(result, options.out); !drawn) {
    std::fprintf(stderr, "haptic_stress: no picture: %s\n", drawn.error().text().c_str());
  }
  std::printf("%s\n", report.dump(2).c_str());
  return report.at("pass").get<bool>() ? 0 : 1;
}

int touched(RunPlan plan, const TouchRunOptions& options) {
  const auto report = runTouched(std::move(plan), options);
  std::ofstream(options.out / "touch.json") << report.dump(2) << '\n';
  std::printf("%s\n", report.dump(2).c_str());
  return report.at("pass").get<bool>() ? 0 : 1;
}

int pinched(RunPlan plan, const PinchRunOptions& options) {
  const auto report = runPinched(std::move(plan), options);
  std::ofstream(options.out / "pinch.json") << report.dump(2) << '\n';
  std::printf("%s\n", report.dump(2).c_str());
  return report.at("pass").get<bool>() ? 0 : 1;
}

int everyTick(RunPlan plan, const TicksRunOptions& options) {
  const auto report = runTicks(std::move(plan), options);
  std::ofstream(options.out / "ticks.json") << report.dump(2) << '\n';
  std::printf("%s\n", report.dump(2).c_str());
  return report.at("pass").get<bool>() ? 0 : 1;
}

int shown(const RunPlan& plan, const AudienceRunOptions& options) {
  const auto report = runAudience(plan, options);
  std::ofstream(options.out / "audience.json") << report.dump(2) << '\n';
  std::printf("%s\n", report.dump(2).c_str());
  return report.at("pass").get<bool>() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  RunPlan plan;
  RunOptions options;
  ClientOptions client;
  TouchRunOptions touch;
  TouchViewerOptions viewer;
  PinchRunOptions pinch;
  HandLeaderOptions leader;
  AudienceRunOptions audience;
  WatchersOptions watchers;
  std::string address, journal, summary;
  bool noViewer = false, viewOnly = false;
  CLI::App app("Real processes on a bad network, editing, being killed and stopped: what is left of them",
               "haptic_stress");
  app.footer(kExamples);
  app.fallthrough();
  addPlan(app, plan);
  app.add_option("--out", options.out, "Where results and journals go")->type_name("DIR")->default_str("out");
  app.add_flag("--relay", options.relay, "No network namespaces, even as root");
  app.add_flag("--no-viewer", noViewer, "Without the real graphics_client");
  auto* asClient = app.add_subcommand("client")->group("");
  auto* asDribbler = app.add_subcommand("dribble")->group("");
  auto* asViewer = app.add_subcommand("look")->group("");
  auto* asLeader = app.add_subcommand("lead")->group("");
  for (auto* verb : {asClient, asDribbler, asViewer, asLeader}) verb->add_option("--connect", address);
  asClient->add_option("--number", client.number);
  asClient->add_option("--life", client.life);
  asClient->add_option("--journal", journal);
  asClient->add_flag("--udp", client.datagrams);
  asClient->add_flag("--view", viewOnly);
  asViewer->add_option("--number", viewer.number);
  asViewer->add_option("--summary", summary);
  asViewer->add_flag("--udp", viewer.datagrams);
  asLeader->add_option("--hand", leader.hand);
  asLeader->add_option("--from", leader.began_ns);
  auto* asWatchers = app.add_subcommand("watch")->group("");
  asWatchers->add_option("--nats", watchers.nats);
  asWatchers->add_option("--session", watchers.session);
  asWatchers->add_option("--count", watchers.count);
  asWatchers->add_option("--viewers", watchers.viewers);
  asWatchers->add_option("--summary", summary);
  auto* asAudience = app.add_subcommand(
      "audience", "A session is published to many: does the servo notice, are samples young, do all hold the same?");
  asAudience->add_option("--watchers", audience.watchers, "That hold the session")
      ->check(CLI::Range(1, 4000))
      ->capture_default_str();
  asAudience->add_option("--viewers", audience.viewers, "Of the watchers, those that hold all assets as well")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  asAudience->add_option("--nodes", audience.nodes, "NATS servers; of three the one that leads the stream is killed")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  asAudience->add_option("--kills", audience.kills, "Of the relay")->check(CLI::Range(0, 1000))->capture_default_str();
  asAudience->add_option("--scene", audience.scene, "That is published")->required()->check(CLI::ExistingFile);
  auto* asPinch = app.add_subcommand(
      "pinch", "Two clients lead a hand each, which pinch a brick and lift it: is it held, and seen where it is held?");
  asPinch->add_option("--viewers", pinch.viewers, "That look on")->check(CLI::Range(1, 32))->capture_default_str();
  auto* asTicks = app.add_subcommand("ticks", "A client has every tick: is each there, or named as missing?");
  auto* asTouch = app.add_subcommand(
      "touch",
      "Bodies are pushed and soft objects dented: do viewers see contacts where they are, and the same shapes?");
  asTouch->add_option("--viewers", touch.viewers, "That look on")->check(CLI::Range(1, 32))->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (asDribbler->parsed()) runDribbler(endpointOrThrow(address));
    if (asClient->parsed()) {
      client.server = endpointOrThrow(address);
      client.journal = journal;
      client.edits = !viewOnly;
      runClient(plan, client);
      return 0;
    }
    if (asViewer->parsed()) {
      viewer.server = endpointOrThrow(address);
      viewer.summary = summary;
      runTouchViewer(viewer);
      return 0;
    }
    if (asWatchers->parsed()) {
      watchers.summary = summary;
      runWatchers(watchers);
      return 0;
    }
    if (asLeader->parsed()) {
      leader.server = endpointOrThrow(address);
      runHandLeader(leader);
      return 0;
    }
    if (options.out.empty()) options.out = "out";
    options.out = std::filesystem::absolute(options.out);
    if (asAudience->parsed()) {
      audience.out = options.out;
      if (app.count("--edits") == 0) plan.edits_Hz = 2;
      return shown(plan, audience);
    }
    if (asPinch->parsed()) {
      pinch.out = options.out;
      pinch.relay = options.relay;
      if (app.count("--cut-ms") == 0) plan.cut_ms = 0;
      return pinched(plan, pinch);
    }
    if (asTicks->parsed()) {
      if (app.count("--cut-ms") == 0) plan.cut_ms = 0;
      return everyTick(plan, {options.out, options.relay});
    }
    if (asTouch->parsed()) {
      touch.out = options.out;
      touch.relay = options.relay;
      if (app.count("--cut-ms") == 0) plan.cut_ms = 0;
      return touched(plan, touch);
    }
    options.viewer = !noViewer;
    return stressed(plan, options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_stress: %s\n", error.what());
    return 1;
  }
}
