#include "tests/stress/picture.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "tests/eval/figure/figure.h"
#include "tests/stress/statistics.h"

namespace haptics::stress {
namespace {

using Figure = nlohmann::ordered_json;

constexpr double kBins = 600;
constexpr double kServoPeriod_ns = 1e6;

/// Values by moment, of which a curve shows one quantile a bin.
class Bins {
 public:
  explicit Bins(const RunPlan& plan) : plan_(plan), values_(static_cast<std::size_t>(kBins)) {}
  void add(std::uint64_t time_ns, double value) {
    if (time_ns < plan_.began_ns || time_ns >= plan_.end_ns()) return;
    const double share = plan_.secondsAt(time_ns) / plan_.seconds;
    values_[std::min(values_.size() - 1, static_cast<std::size_t>(share * kBins))].push_back(value);
  }
  [[nodiscard]] Figure curve(const char* name, const char* colour, double quantile) {
    Figure points = Figure::array();
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (values_[i].empty()) continue;
      points.push_back({(static_cast<double>(i) + 0.5) / kBins * plan_.seconds, percentile(values_[i], quantile)});
    }
    return {{"name", name}, {"colour", colour}, {"points", std::move(points)}};
  }

 private:
  const RunPlan& plan_;
  std::vector<std::vector<double>> values_;
};

Figure agePanel(const RunResult& result) {
  Bins udp(result.plan), tcp(result.plan);
  for (const ClientLife& life : result.evidence.lives) {
    for (const Record& record : life.records) {
      if (life.stopped || record.kind != Record::Kind::kView || (record.flags & Record::kAgeKnown) == 0) continue;
      ((record.flags & Record::kByDatagram) != 0 ? udp : tcp)
          .add(record.time_ns, 1e-6 * static_cast<double>(record.age_ns));
    }
  }
  return {{"title", "Age of the newest sample, ms: the oldest of all clients'"},
          {"decades", {1, 4}},
          {"curves", {tcp.curve("by TCP", "tcp", 1), udp.curve("by UDP", "udp", 1)}}};
}

Figure lagPanel(const RunResult& result) {
  Bins lag(result.plan);
  const auto& commits = result.evidence.commits;
  for (const ClientLife& life : result.evidence.lives) {
    for (const Record& record : life.records) {
      if (life.stopped || record.kind != Record::Kind::kView || record.revision == 0) continue;
      const auto next = std::ranges::upper_bound(commits, record.time_ns, {}, &Auditor::Commit::time_ns);
      if (next == commits.begin()) continue;
      const std::uint64_t newest = std::prev(next)->revision;
      lag.add(record.time_ns, newest > record.revision ? static_cast<double>(newest - record.revision) : 0);
    }
  }
  return {{"title", "Revisions behind the server"},
          {"decades", {0, 4}},
          {"curves", {lag.curve("the last client", "tcp", 1), lag.curve("median", "udp", 0.5)}}};
}

Figure servoPanel(const RunResult& result) {
  Bins late(result.plan), missed(result.plan);
  const auto& pulses = result.evidence.pulses;
  for (std::size_t begin = 0, end = 0; begin < pulses.size(); begin = end) {
    double start_ns = std::numeric_limits<double>::infinity();  // of tick 0 in this life of the server
    const auto ofTick0_ns = [&](const Auditor::Pulse& pulse) {
      return static_cast<double>(static_cast<std::int64_t>(pulse.device_ns - pulses[begin].device_ns)) -
             static_cast<double>(pulse.tick) * kServoPeriod_ns;
    };
    for (end = begin; end < pulses.size() && pulses[end].life == pulses[begin].life; ++end) {
      start_ns = std::min(start_ns, ofTick0_ns(pulses[end]));
    }
    for (std::size_t i = begin + 1; i < end; ++i) {
      late.add(pulses[i].device_ns, 1e-3 * (ofTick0_ns(pulses[i]) - start_ns));
      missed.add(pulses[i].device_ns, static_cast<double>(pulses[i].missedTicks - pulses[i - 1].missedTicks));
    }
  }
  return {{"title", "Servo's wake-ups, us late, and most ticks missed in 5 ms"},
          {"decades", {0, 4}},
          {"curves",
           {late.curve("latest", "servo", 1), late.curve("median", "udp", 0.5),
            missed.curve("missed ticks", "missed", 1)}}};
}

}  // namespace

void drawPicture(const RunResult& result, const std::filesystem::path& folder) {
  const RunPlan& plan = result.plan;
  char line[256], attack[256];
  std::snprintf(line, sizeof line,
                "%s: round trip %g ms, jitter %g ms each way, %g %% lost, cut for %g ms every %g s (grey)",
                result.network.c_str(), plan.rtt_ms, plan.jitter_ms, plan.loss_pct, plan.cut_ms, plan.cutEvery_s);
  std::snprintf(
      attack, sizeof attack,
      "Under attack (tinted): %g edits a second of each client, one viewer that dribbles, and what stands above "
      "the panels",
      plan.edits_Hz);
  Figure bands = Figure::array(), events = Figure::array();
  for (double from_s = plan.block_s(); from_s < plan.seconds; from_s += 2 * plan.block_s()) {
    bands.push_back({from_s, std::min(plan.seconds, from_s + plan.block_s()), "attack"});
  }
  for (double to_s = plan.cutEvery_s; plan.cut_ms > 0 && to_s <= plan.seconds; to_s += plan.cutEvery_s) {
    bands.push_back({to_s - plan.cut_ms * 1e-3, to_s, "cut"});
  }
  for (const Disturbance& disturbance : result.disturbances) {
    std::string what = disturbance.what;
    if (const auto at = what.find("graphics_client"); at == 0) what = "viewer" + what.substr(15);
    events.push_back({plan.secondsAt(disturbance.time_ns), what});
  }
  eval::drawFigure("timeline",
                   {{"title", std::to_string(plan.clients) + " editing clients on a bad network"},
                    {"caption", {line, attack}},
                    {"seconds", plan.seconds},
                    {"bands", std::move(bands)},
                    {"events", std::move(events)},
                    {"panels", {agePanel(result), lagPanel(result), servoPanel(result)}}},
                   folder / "stress");
}

}  // namespace haptics::stress
