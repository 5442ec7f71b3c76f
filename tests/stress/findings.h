#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/stress/auditor.h"
#include "tests/stress/journal.h"
#include "tests/stress/run_plan.h"

namespace haptics::stress {

/// One life of a client process, as it wrote it down.
struct ClientLife {
  int client = 0;
  std::uint64_t life = 0;
  bool datagrams = false;
  bool stopped = false;  ///< The viewer that is stopped: its ages say how long that was.
  std::vector<Record> records;
};

/// Everything that a run left.
struct Evidence {
  std::vector<ClientLife> lives;
  std::vector<Auditor::Commit> commits;
  std::vector<Auditor::Pulse> pulses;
  std::uint64_t auditorGaps = 0;
  std::map<std::string, std::string> roots;  ///< At the end, in hexadecimal digits, by who holds it.
  std::map<std::uint64_t, std::vector<double>> serverResident_MB;  ///< Over time, by the server's life.
};

struct Edits {
  std::uint64_t submitted = 0, accepted = 0, conflicts = 0, rejected = 0, unanswered = 0;
  std::uint64_t increments = 0, counter = 0;
  std::uint64_t lostAcked = 0, duplicated = 0, lostIncrements = 0, gaps = 0;
};
[[nodiscard]] Edits judgeEdits(const Evidence& evidence);

/// How long after each quiet began all clients held what the server held; the last is the run's end. Negative: not before
/// the quiet was over.
[[nodiscard]] std::vector<double> secondsToEqual(const Evidence& evidence, const RunPlan& plan);

/// Telemetry age in ms by the path in use and phase, and the error of the clients' estimates of it.
[[nodiscard]] nlohmann::ordered_json ages(const Evidence& evidence, const RunPlan& plan);

struct MissedTicks {
  std::uint64_t ticks = 0, missed = 0, bursts = 0;  ///< A burst: ticks missed between two looks, 5 ms apart.
};
struct Punctuality {
  MissedTicks quiet, attack;
  double pTicks = 1, pBursts = 1;
};
[[nodiscard]] Punctuality judgeServo(const Evidence& evidence, const RunPlan& plan);
/// `isAttack` tells the phase of a tick by when the device was read (monotonic, ns), or that it counts for neither.
[[nodiscard]] Punctuality judgeServo(const std::vector<Auditor::Pulse>& pulses,
                                     const std::function<std::optional<bool>(std::uint64_t)>& isAttack);

/// Of one server's life, in MB, from a few seconds after its start.
[[nodiscard]] double residentGrowth_MB(const Evidence& evidence);

}  // namespace haptics::stress
