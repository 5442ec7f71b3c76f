#include "tests/stress/touch_viewer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/mesh/file_bytes.h"
#include "graphics_client/mirror/playback.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/viewer/run_summary.h"
#include "tests/stress/statistics.h"

namespace haptics::stress {
namespace {

constexpr double kFrames_Hz = 60;
/// From here on a contact counts as one of a hand that moves (m/s).
constexpr double kMoving_m_per_s = 0.1;
constexpr std::size_t kWorstTold = 5;

std::atomic<bool> stopRequested{false};

/// How fast the hand is, between the newest two samples.
class HandSpeed {
 public:
  double of(const TelemetrySample& sample) {
    if (sample.time_ns > last_.time_ns) {
      if (last_.time_ns != 0) {
        speed_m_per_s_ =
            glm::distance(sample.hip, last_.hip) / (1e-9 * static_cast<double>(sample.time_ns - last_.time_ns));
      }
      last_ = sample;
    }
    return speed_m_per_s_;
  }

 private:
  TelemetrySample last_{};
  double speed_m_per_s_ = 0;
};

struct SeenContact {
  double time_s = 0, error_mm = 0, speed_m_per_s = 0;
  ObjectId object = 0;
};

nlohmann::ordered_json spread(std::vector<double> errors_mm) {
  return {{"frames", errors_mm.size()},
          {"p50", percentile(errors_mm, 0.5)},
          {"p99", percentile(errors_mm, 0.99)},
          {"max", percentile(errors_mm, 1)}};
}

nlohmann::ordered_json contactsOf(std::vector<SeenContact> seen) {
  std::vector<double> all_mm, moving_mm;
  for (const SeenContact& contact : seen) {
    all_mm.push_back(contact.error_mm);
    if (contact.speed_m_per_s >= kMoving_m_per_s) moving_mm.push_back(contact.error_mm);
  }
  nlohmann::ordered_json json{{"all", spread(all_mm)}, {"at_0.1_m_per_s_or_faster", spread(moving_mm)}};
  const std::size_t told = std::min(kWorstTold, seen.size());
  const auto worseFirst = [](const SeenContact& a, const SeenContact& b) { return a.error_mm > b.error_mm; };
  std::ranges::partial_sort(seen, seen.begin() + static_cast<std::ptrdiff_t>(told), worseFirst);
  for (const SeenContact& contact : std::span(seen).first(told)) {
    json["worst"].push_back({{"time_s", contact.time_s},
                             {"object", contact.object},
                             {"error_mm", contact.error_mm},
                             {"hand_m_per_s", contact.speed_m_per_s}});
  }
  return json;
}

}  // namespace

void runTouchViewer(const TouchViewerOptions& options) {
  std::signal(SIGTERM, [](int) { stopRequested = true; });
  ServerLink link({.server = options.server,
                   .clientName = "touch viewer " + std::to_string(options.number),
                   .telemetryRate_Hz = kFrames_Hz,
                   .datagrams = options.datagrams});
  Playback playback;
  RunSummary summary;
  HandSpeed hand;
  std::vector<SeenContact> seen;
  bool joined = false;
  const auto period_ns = static_cast<std::uint64_t>(1e9 / kFrames_Hz);
  const std::uint64_t began_ns = monotonicNow_ns();
  for (std::uint64_t next_ns = began_ns; !stopRequested; next_ns = std::max(next_ns + period_ns, monotonicNow_ns())) {
    const std::uint64_t before_ns = monotonicNow_ns();
    if (next_ns > before_ns) std::this_thread::sleep_for(std::chrono::nanoseconds(next_ns - before_ns));
    const auto newest = link.latest();
    const std::uint64_t now_ns = monotonicNow_ns();
    const double time_s = 1e-9 * static_cast<double>(now_ns - began_ns);
    const auto shown = playback.at(newest, now_ns);
    summary.addFrame(newest, newest->telemetryAgeAt_s(now_ns), time_s);
    if (!joined && newest->hashesEqual) {
      joined = true;
      std::printf("holds the scene\n");
      std::fflush(stdout);
    }
    if (!newest->sample) continue;
    const double speed_m_per_s = hand.of(*newest->sample);
    if (const auto error_m = summary.addContact(*shown)) {
      seen.push_back({time_s, *error_m * 1e3, speed_m_per_s, shown->sample->object});
    }
  }
  auto json = nlohmann::ordered_json::parse(summary.json());
  json["contacts"] = contactsOf(std::move(seen));
  if (const auto written = writeFile(options.summary, json.dump(2)); !written) {
    throw std::runtime_error(written.error().text());
  }
}

}  // namespace haptics::stress
