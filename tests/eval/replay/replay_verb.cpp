#include "tests/eval/replay/replay_verb.h"

#include <chrono>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "common/text/printable.h"
#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/recording/replay.h"
#include "tests/eval/replay/telemetry_file.h"
#include "tests/eval/report.h"

namespace haptics::eval {
namespace {

[[nodiscard]] unsigned long long count(std::uint64_t value) { return value; }

[[nodiscard]] Record recordOf(const ReplayOptions& options, const ReplayOutcome& outcome, double seconds) {
  Record record = {{"method", "ours"},
                   {"scene", options.recording.filename().string()},
                   {"server", outcome.facts.server},
                   {"device", outcome.facts.device},
                   {"why", outcome.facts.why},
                   {"rate_Hz", outcome.facts.rate_Hz},
                   {"same_step", outcome.sameStep},
                   {"ticks", outcome.ticks},
                   {"missed_ticks", outcome.missed},
                   {"contact_ticks", outcome.contactTicks},
                   {"scenes", outcome.scenes},
                   {"differing_ticks", outcome.differing},
                   {"largest_difference_N", outcome.largestDifference_N},
                   {"largest_difference_Nm", outcome.largestDifference_Nm}};
  if (outcome.first) {
    record["first_difference_tick"] = outcome.first->tick;
    record["first_difference_N"] = glm::distance(outcome.first->recorded_N, outcome.first->now_N);
  }
  record["cut_off"] = outcome.cutOff;
  record["refusal"] = outcome.refusal ? outcome.refusal->text() : "";
  record["ns_per_tick"] = outcome.ticks > 0 ? seconds * 1e9 / static_cast<double>(outcome.ticks) : 0;
  record["pass"] = !outcome.refusal && outcome.differing == 0;
  return record;
}

void print(const ReplayOutcome& outcome, double seconds) {
  const RecordingFacts& facts = outcome.facts;
  const double length_s = static_cast<double>(outcome.ticks + outcome.missed) * facts.config.period_s;
  std::printf("%s, %s at %.0f Hz, %s\n", printable(facts.server).c_str(), printable(facts.device).c_str(),
              facts.rate_Hz, printable(facts.why).c_str());
  if (!outcome.sameStep) std::printf("recorded by another version of the step: its forces may differ\n");
  std::printf("%llu ticks (%.1f s, %llu missed), %llu in contact, %llu scenes; replayed in %.1f s\n",
              count(outcome.ticks), length_s, count(outcome.missed), count(outcome.contactTicks), count(outcome.scenes),
              seconds);
  if (outcome.cutOff)
    std::printf("the recording was cut off while it was being written: it ends with the last whole part\n");
  if (outcome.first) {
    const ReplayDifference& d = *outcome.first;
    std::printf(
        "%llu forces differ, by up to %.3g N; the first at tick %llu: recorded (%.17g, %.17g, %.17g) N, "
        "now (%.17g, %.17g, %.17g) N\n",
        count(outcome.differing), outcome.largestDifference_N, count(d.tick), d.recorded_N.x, d.recorded_N.y,
        d.recorded_N.z, d.now_N.x, d.now_N.y, d.now_N.z);
  } else if (outcome.ticks > 0) {
    std::printf("every force is the recorded one, bit for bit\n");
  }
  if (outcome.refusal) std::printf("not replayed to its end: %s\n", printable(outcome.refusal->text()).c_str());
}

}  // namespace

bool runReplay(const ReplayOptions& options, const std::filesystem::path& out) {
  const auto file = RecordingBytes::open(options.recording);
  if (!file) throw std::runtime_error(options.recording.string() + ": " + file.error().text());
  std::optional<TelemetryFile> telemetry;
  if (!options.telemetry.empty()) {
    auto opened = TelemetryFile::open(options.telemetry);
    if (!opened) throw std::runtime_error("--telemetry " + opened.error().text());
    telemetry = *std::move(opened);
  }
  const auto began = std::chrono::steady_clock::now();
  const auto outcome = replay(*file, [&](const ReplayedTick& tick) {
    if (telemetry) telemetry->write(tick);
    return true;
  });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (!outcome) throw std::runtime_error(options.recording.string() + ": " + outcome.error().text());
  if (telemetry && !telemetry->close())
    throw std::runtime_error("--telemetry " + options.telemetry + ": is incomplete");
  print(*outcome, seconds);
  const Record record = recordOf(options, *outcome, seconds);
  writeRecords(out, "replay", {record});
  return record["pass"].get<bool>();
}

}  // namespace haptics::eval
