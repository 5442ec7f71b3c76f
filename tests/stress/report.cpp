#include "tests/stress/report.h"

namespace haptics::stress {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kEqualWithin_s = 5, kMaxGrowth_MB = 64, kMaxAgeUdp_ms = 200, kMaxAgeTcp_ms = 1500, kMinP = 0.001;

Json toJson(const MissedTicks& phase) {
  return {{"ticks", phase.ticks},
          {"missed", phase.missed},
          {"bursts", phase.bursts},
          {"rate", phase.ticks > 0 ? static_cast<double>(phase.missed) / static_cast<double>(phase.ticks) : 0}};
}

Json counts(const RunResult& result) {
  std::uint64_t connections = 0, resyncs = 0, stateResets = 0;
  for (const ClientLife& life : result.evidence.lives) {
    Record last;
    for (const Record& record : life.records) {
      if (record.kind == Record::Kind::kLink) last = record;
    }
    connections += last.number > 0 ? last.number - 1 : 0;
    resyncs += last.value;
    stateResets += last.revision;
  }
  std::map<std::string, int> done;
  for (const Disturbance& disturbance : result.disturbances) ++done[disturbance.what];
  return {{"reconnects", connections}, {"resyncs", resyncs}, {"state_resets", stateResets}, {"disturbances", done}};
}

}  // namespace

Json makeReport(const RunResult& result) {
  const Evidence& evidence = result.evidence;
  const RunPlan& plan = result.plan;
  const Edits edits = judgeEdits(evidence);
  const auto toEqual = secondsToEqual(evidence, plan);
  const auto servo = judgeServo(evidence, plan);
  bool rootsEqual = !evidence.roots.at("server").empty();
  for (const auto& [who, root] : evidence.roots) rootsEqual &= root == evidence.roots.at("server");
  const Json age = ages(evidence, plan);
  const bool isNetwork = !result.network.starts_with("relay");

  Json report{{"network", result.network},
              {"clients", plan.clients},
              {"rtt_ms", plan.rtt_ms},
              {"jitter_ms", plan.jitter_ms},
              {"loss_pct", plan.loss_pct},
              {"cut_every_s", plan.cutEvery_s},
              {"cut_ms", plan.cut_ms},
              {"seconds", plan.seconds},
              {"edits_per_second_of_each", plan.edits_Hz},
              {"seed", plan.seed},
              {"packets", result.counts.packets},
              {"packets_lost", result.counts.lost},
              {"packets_late_by_this_machine_ms_p99", result.counts.late_ms}};
  report["roots_equal"] = rootsEqual;
  report["seconds_to_equal"] = toEqual.empty() ? -1 : toEqual.back();
  std::vector<double> whole = toEqual;
  std::erase_if(whole, [](double s) { return s < 0; });
  report["seconds_to_equal_in_each_quiet"] = {{"quiets", toEqual.size()},
                                              {"reached", whole.size()},
                                              {"longest", whole.empty() ? -1 : *std::ranges::max_element(whole)}};
  report["lost_acked_edits"] = edits.lostAcked;
  report["duplicated_edits"] = edits.duplicated;
  report["revision_gaps"] = edits.gaps;
  report["lost_increments"] = edits.lostIncrements + (edits.increments - std::min(edits.increments, edits.counter));
  report["server_rss_growth_mb"] = residentGrowth_MB(evidence);
  report["telemetry_age_ms"] = age;
  report["missed_tick_rate"] = {{"blocks", static_cast<int>(plan.seconds / plan.block_s())},
                                {"quiet", toJson(servo.quiet)},
                                {"attack", toJson(servo.attack)},
                                {"p_bursts", servo.pBursts},
                                {"p_ticks", servo.pTicks}};
  report["edits"] = {{"submitted", edits.submitted},   {"accepted", edits.accepted},
                     {"conflicts", edits.conflicts},   {"rejected", edits.rejected},
                     {"unanswered", edits.unanswered}, {"committed", evidence.commits.size()},
                     {"increments", edits.increments}, {"counter", edits.counter}};
  report["counts"] = counts(result);
  report["roots"] = evidence.roots;

  Json limits;
  limits["roots_equal"] = rootsEqual;
  limits["equal_within_5_s"] = !toEqual.empty() && toEqual.back() >= 0 && toEqual.back() <= kEqualWithin_s;
  limits["no_edit_lost_or_doubled"] = edits.lostAcked + edits.duplicated + edits.lostIncrements == 0 &&
                                      edits.accepted > 0 && edits.increments == edits.counter;
  limits["no_revision_gaps"] = edits.gaps == 0;
  limits["server_rss_growth_below_64_mb"] = residentGrowth_MB(evidence) < kMaxGrowth_MB;
  limits["server_ended_well"] = result.serverEndedWell;
  if (isNetwork) {  // a relay's streams and this machine's load say nothing of ages
    limits["age_udp_p99_below_200_ms"] = age["udp"]["outside_cuts"]["p99"] < kMaxAgeUdp_ms;
    limits["age_tcp_p99_below_1500_ms"] = age["tcp"]["outside_cuts"]["p99"] < kMaxAgeTcp_ms;
    limits["missed_ticks_of_one_rate"] = servo.pBursts > kMinP;
  }
  bool pass = true;
  for (const auto& [name, holds] : limits.items()) pass &= holds.get<bool>();
  report["holds"] = limits;
  report["pass"] = pass;
  return report;
}

}  // namespace haptics::stress
