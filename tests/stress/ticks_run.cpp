#include "tests/stress/ticks_run.h"

#include <atomic>
#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/telemetry/tick_gaps.h"
#include "common/wire/convert.h"
#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/recording/replay.h"
#include "tests/stress/run_files.h"

namespace haptics::stress {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kJoining_s = 60;
/// For what is on its way at the end.
constexpr double kArrives_s = 20;

constexpr const char* kScene = R"(
operations { add { name: "torus" mesh { torus { major_radius_m: 0.042 minor_radius_m: 0.018 } }
  pose { position { x: -0.06 z: 0.018 } } material { friction { mu_static: 0.6 mu_dynamic: 0.4 } } } }
operations { add { name: "box" mesh { box { size_m { x: 0.07 y: 0.07 z: 0.05 } segments: 4 } }
  pose { position { x: 0.06 z: 0.025 } } } }
)";

/// What the client has. Filled in on the link's thread, read once that has ended.
struct Stream {
  std::map<std::uint64_t, Vec3> forces_N;
  std::map<std::uint64_t, TickGap> gaps;  // by the tick before
  TickGaps finder;
  std::atomic<std::uint64_t> newest{0};

  void take(const v1::TelemetryBatch& batch) {
    for (const v1::Telemetry& message : batch.sample()) {
      const TelemetrySample sample = fromWire(message);
      if (const auto gap = finder.next(sample.tick, sample.missedTicks)) gaps[gap->after] = *gap;
      forces_N[sample.tick] = sample.force.written;
      newest = sample.tick;
    }
  }
  [[nodiscard]] bool namesAsMissing(std::uint64_t tick) const {
    const auto after = gaps.lower_bound(tick);
    if (after == gaps.begin()) return false;
    const TickGap& gap = std::prev(after)->second;
    return tick > gap.after && tick <= gap.after + gap.missed + gap.lost;
  }
};

/// Of the recorded ticks from the stream's first to its last one.
Json compared(const Stream& stream, const std::filesystem::path& recording) {
  std::uint64_t recorded = 0, equal = 0, named = 0, unexplained = 0;
  const auto bytes = RecordingBytes::open(recording);
  if (!bytes) throw std::runtime_error(bytes.error().text());
  const auto outcome = replay(*bytes, [&](const ReplayedTick& tick) {
    const std::uint64_t number = tick.sample.tick;
    if (number < stream.forces_N.begin()->first || number > stream.forces_N.rbegin()->first) return true;
    ++recorded;
    const auto found = stream.forces_N.find(number);
    if (found == stream.forces_N.end()) {
      ++(stream.namesAsMissing(number) ? named : unexplained);
    } else {
      equal += std::memcmp(&found->second, &tick.sample.force.written, sizeof(Vec3)) == 0 ? 1 : 0;
    }
    return true;
  });
  if (!outcome) throw std::runtime_error(outcome.error().text());
  return {{"recorded_ticks", recorded},
          {"ticks_with_the_same_force", equal},
          {"ticks_named_as_lost", named},
          {"ticks_missing_unnamed", unexplained}};
}

}  // namespace

Json runTicks(RunPlan plan, const CastOptions& options) {
  const auto network = makeNetwork(plan, options.relay, options.out);
  const auto recording = options.out / "ticks.recording";
  ServerProcess server(*network, options.out, kScene, {"--record", recording.string()});
  const auto endpoint = parseEndpoint(network->clientAddress(server.port()));
  if (!endpoint) throw std::runtime_error(endpoint.error().text());
  plan.began_ns = monotonicNow_ns();
  network->start();
  Stream stream;
  std::unique_ptr<ServerLink> link;
  std::thread([&] {
    network->enterClientSide();
    link = std::make_unique<ServerLink>(
        ServerLink::Options{.server = *endpoint,
                            .clientName = "every tick",
                            .telemetryRate_Hz = 0,
                            .fetchAssets = false,
                            .onTicks = [&stream](const v1::TelemetryBatch& batch) { stream.take(batch); }});
  }).join();
  waitUntil(kJoining_s, "a tick has come", [&] { return stream.newest != 0; });
  const std::uint64_t end_ns = monotonicNow_ns() + static_cast<std::uint64_t>(1e9 * plan.seconds);
  while (monotonicNow_ns() < end_ns) {
    server.checkAlive();
    std::this_thread::sleep_for(kLook);
  }
  const std::uint64_t lastWanted = stream.newest;
  waitUntil(kArrives_s, "what was on its way has come", [&] { return stream.newest > lastWanted + 1'000; });
  const std::uint64_t connections = link->latest()->connections;
  link.reset();
  Json report = headOf(plan, *network);
  const bool endedWell = server.stop();
  const Json summary = server.summary();
  report["server"] = {{"ticks", summary.at("ticks")}, {"missed_ticks", summary.at("missed_ticks")}};
  report["connections"] = connections;
  report["streamed_ticks"] = stream.forces_N.size();
  report["gaps"] = stream.gaps.size();
  report["missed_by_the_servo"] = stream.finder.missed();
  report["lost_on_the_way"] = stream.finder.lost();
  report["compared"] = compared(stream, recording);
  const Json& found = report["compared"];
  Json holds;
  holds["every_tick_is_there_or_named"] = found.at("ticks_missing_unnamed") == 0;
  holds["every_force_is_the_recorded_one"] = found.at("ticks_with_the_same_force") == stream.forces_N.size();
  holds["ticks_came_all_the_time"] = static_cast<double>(stream.forces_N.size()) > 0.5 * 1'000 * plan.seconds;
  holds["server_ended_well"] = endedWell;
  conclude(report, *network, std::move(holds));
  return report;
}

}  // namespace haptics::stress
