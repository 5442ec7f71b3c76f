#include "tests/stress/findings.h"

#include <set>
#include <tuple>

#include "tests/stress/statistics.h"

namespace haptics::stress {
namespace {

using Kind = Record::Kind;

/// After a server's start, in which it builds the scene and clients join.
constexpr double kWarmUp_s = 2;

using OwnEdit = std::pair<std::string, EditName>;

std::uint64_t countDoubles(const std::vector<Auditor::Commit>& commits) {
  std::set<OwnEdit> seen;
  std::uint64_t doubles = 0;
  for (const auto& commit : commits) {
    for (const OwnEdit& mark : commit.marks) doubles += seen.insert(mark).second ? 0 : 1;
  }
  return doubles;
}

bool backwards(const ClientLife& life) {
  std::uint64_t last = 0;
  for (const Record& record : life.records) {
    if (record.kind != Kind::kView) continue;
    if (record.revision < last) return true;
    last = record.revision;
  }
  return false;
}

nlohmann::ordered_json quantiles(std::vector<double>& values) {
  return {{"samples", values.size()}, {"p50", percentile(values, 0.5)}, {"p99", percentile(values, 0.99)}};
}

}  // namespace

Edits judgeEdits(const Evidence& evidence) {
  Edits edits;
  std::map<std::uint64_t, const Auditor::Commit*> byRevision;
  std::uint64_t counter = 0;
  for (const auto& commit : evidence.commits) {
    byRevision[commit.revision] = &commit;
    if (!commit.counter) continue;
    ++edits.increments;
    if (*commit.counter != counter + 1) ++edits.lostIncrements;
    counter = *commit.counter;
  }
  edits.counter = counter;
  edits.duplicated = countDoubles(evidence.commits);
  edits.gaps = evidence.auditorGaps;
  for (const ClientLife& life : evidence.lives) {
    if (backwards(life)) ++edits.gaps;
    for (const Record& record : life.records) {
      if (record.kind == Kind::kSubmitted) ++edits.submitted;
      if (record.kind == Kind::kConflict) ++edits.conflicts;
      if (record.kind == Kind::kRejected) ++edits.rejected;
      if (record.kind == Kind::kGap) ++edits.gaps;
      if (record.kind != Kind::kAccepted) continue;
      ++edits.accepted;
      const auto commit = byRevision.find(record.revision);
      const OwnEdit mark{markName(life.client), {life.life, record.number}};
      const bool there = commit != byRevision.end() && std::ranges::count(commit->second->marks, mark) == 1 &&
                         commit->second->counter.value_or(0) == record.value;
      if (!there) ++edits.lostAcked;
    }
  }
  edits.unanswered = edits.submitted - edits.accepted - edits.conflicts - edits.rejected;
  return edits;
}

std::vector<double> secondsToEqual(const Evidence& evidence, const RunPlan& plan) {
  std::vector<double> all;
  const auto block_ns = static_cast<std::uint64_t>(plan.block_s() * 1e9);
  std::vector<std::uint64_t> begins;
  for (std::uint64_t begin = plan.began_ns + 2 * block_ns; begin < plan.end_ns(); begin += 2 * block_ns)
    begins.push_back(begin);
  begins.push_back(plan.end_ns());
  for (const std::uint64_t begin_ns : begins) {
    const bool last = begin_ns == plan.end_ns();
    const std::uint64_t end_ns = last ? std::numeric_limits<std::uint64_t>::max() : begin_ns + block_ns;
    const Auditor::Commit* target = nullptr;
    for (const auto& commit : evidence.commits) {
      if (commit.time_ns < end_ns) target = &commit;
    }
    if (target == nullptr) continue;
    std::uint64_t slowest_ns = std::max(begin_ns, target->time_ns);
    bool reached = true;
    for (const ClientLife& life : evidence.lives) {
      bool there = true;  // where it did not live through this quiet
      for (const Record& record : life.records) {
        if (record.kind != Kind::kView || record.time_ns < begin_ns || record.time_ns >= end_ns) continue;
        there =
            record.revision == target->revision && record.root == target->root && (record.flags & Record::kEqual) != 0;
        if (!there) continue;
        slowest_ns = std::max(slowest_ns, record.time_ns);
        break;
      }
      reached &= there;
    }
    all.push_back(reached ? 1e-9 * static_cast<double>(slowest_ns - begin_ns) : -1);
  }
  return all;
}

nlohmann::ordered_json ages(const Evidence& evidence, const RunPlan& plan) {
  std::map<std::tuple<bool, bool>, std::vector<double>> ages_ms;
  std::vector<double> errors_ms;
  std::uint64_t asked = 0, byDatagram = 0;
  for (const ClientLife& life : evidence.lives) {
    if (life.stopped) continue;
    for (const Record& record : life.records) {
      const bool within = record.time_ns >= plan.began_ns && record.time_ns < plan.end_ns();
      if (record.kind != Kind::kView || (record.flags & Record::kAgeKnown) == 0 || !within) continue;
      const bool datagram = (record.flags & Record::kByDatagram) != 0;
      ages_ms[{datagram, plan.cutShowsAt(record.time_ns)}].push_back(1e-6 * static_cast<double>(record.age_ns));
      asked += life.datagrams ? 1 : 0;
      byDatagram += datagram ? 1 : 0;
      if (record.ageByClient_ns != 0) {
        errors_ms.push_back(1e-6 * std::abs(static_cast<double>(record.ageByClient_ns - record.age_ns)));
      }
    }
  }
  nlohmann::ordered_json result;
  for (const bool datagrams : {true, false}) {
    for (const bool inside : {false, true}) {
      result[datagrams ? "udp" : "tcp"][inside ? "inside_cuts" : "outside_cuts"] =
          quantiles(ages_ms[{datagrams, inside}]);
    }
  }
  // For the rest of their time those that asked for UDP had TCP: until the path was proven, or once it was lost.
  result["udp"]["share_of_the_time_of_clients_that_asked"] =
      asked > 0 ? static_cast<double>(byDatagram) / static_cast<double>(asked) : 0;
  result["error_of_the_clients_estimate"] = quantiles(errors_ms);
  return result;
}

Punctuality judgeServo(const Evidence& evidence, const RunPlan& plan) {
  return judgeServo(evidence.pulses, [&plan](std::uint64_t at_ns) -> std::optional<bool> {
    if (at_ns < plan.began_ns || at_ns >= plan.end_ns()) return std::nullopt;
    return plan.attackAt(at_ns);
  });
}

Punctuality judgeServo(const std::vector<Auditor::Pulse>& pulses,
                       const std::function<std::optional<bool>(std::uint64_t)>& isAttack) {
  Punctuality result;
  const Auditor::Pulse* before = nullptr;
  std::uint64_t lifeBegan_ns = 0;
  for (const Auditor::Pulse& pulse : pulses) {
    if (before == nullptr || before->life != pulse.life || pulse.tick < before->tick) lifeBegan_ns = pulse.device_ns;
    const bool settled = 1e-9 * static_cast<double>(pulse.device_ns - lifeBegan_ns) > kWarmUp_s;
    const std::optional<bool> attack = isAttack(pulse.device_ns);
    if (before != nullptr && settled && attack) {
      MissedTicks& phase = *attack ? result.attack : result.quiet;
      const std::uint64_t missed = pulse.missedTicks - before->missedTicks;
      phase.ticks += pulse.tick - before->tick;
      phase.missed += missed;
      phase.bursts += missed > 0 ? 1 : 0;
    }
    before = &pulse;
  }
  const auto quiet = static_cast<double>(result.quiet.ticks), attack = static_cast<double>(result.attack.ticks);
  result.pTicks = poissonP(result.quiet.missed, quiet, result.attack.missed, attack);
  result.pBursts = poissonP(result.quiet.bursts, quiet, result.attack.bursts, attack);
  return result;
}

double residentGrowth_MB(const Evidence& evidence) {
  double growth = 0;
  for (const auto& [life, resident] : evidence.serverResident_MB) {
    if (!resident.empty()) growth = std::max(growth, *std::ranges::max_element(resident) - resident.front());
  }
  return growth;
}

}  // namespace haptics::stress
