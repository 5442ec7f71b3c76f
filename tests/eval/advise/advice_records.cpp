#include "tests/eval/advise/advice.h"

namespace haptics::eval {
namespace {

void addDifference(Record& record, const ForceDifference& difference) {
  record["ticks"] = difference.ticks;
  record["epsilon_p99_ratio"] = difference.epsilon_p99;
  record["epsilon_max_ratio"] = difference.epsilon_max;
  record["missed_contact_ticks"] = difference.missedTicks;
  record["wrong_side_ticks"] = difference.wrongSideTicks;
}

Record meshRecord(const ObjectAdvice& object, std::size_t i) {
  const Candidate& c = object.candidates[i];
  Record record{{"method", "ours"},   {"scene", object.name},           {"triangles", c.triangles},
                {"own_mesh", i == 0}, {"advised", i == object.advised}, {"deviation_mm", c.deviation_mm}};
  addDifference(record, c.difference);
  record.update({{"opened", c.opened},
                 {"strayed", c.strayed},
                 {"hot_tick_p50_ns", c.hot_ns},
                 {"cold_tick_p50_ns", c.cold_ns},
                 {"memory_MB", c.memory_MB},
                 {"pass", c.good()}});
  if (i + 1 == object.advised || i == object.advised + 1) {
    record.update({{"step", i < object.advised ? "up" : "down"},
                   {"memory_step_MB", c.memory_MB - object.mesh().memory_MB},
                   {"hot_tick_step_ns", c.hot_ns - object.mesh().hot_ns}});
  }
  return record;
}

Record verdictRecord(const ObjectAdvice& object) {
  Record record{{"method", "ours"},
                {"scene", object.name},
                {"verdict", object.verdict.text},
                {"replaces_mesh", object.verdict.use},
                {"pass", object.checkedWell()}};
  if (object.checked) {
    record.update(
        {{"checked_ticks", object.checked->ticks}, {"checked_below_1_ratio", 1 - object.checked->felt_ratio}});
  }
  return record;
}

Record featureRecord(const ObjectAdvice& object, const SceneFeature& feature) {
  Record record{{"method", "ours"}, {"scene", object.name}, {"feature", feature.name}, {"judged", feature.judged()}};
  if (!feature.judged()) {
    record["why"] = feature.whyNot;
    return record;
  }
  record.update(
      {{"felt", feature.felt()}, {"epsilon_p99_ratio", feature.epsilon_p99}, {"tick_cost_ns", feature.cost_ns}});
  return record;
}

Record motionRecord(const ObjectAdvice& object, const FailureMotion& motion) {
  return {{"method", "ours"},
          {"scene", object.name},
          {"motion", motion.name},
          {"inside_ticks", motion.insideTicks},
          {"longest_inside_ticks", motion.longestInside},
          {"deepest_inside_mm", motion.deepestInside_mm},
          {"pass", motion.holds()}};
}

Record optionRecord(const SceneAdvice& advice, const ObjectAdvice& object, const MaterialOption& option,
                    std::size_t rate) {
  const Trial& trial = option.trials[rate];
  Record record{{"method", "ours"},
                {"scene", object.name},
                {"stiffness_N_per_m", option.stiffness_N_per_m},
                {"damping_Ns_per_m", option.damping_Ns_per_m},
                {"own_material", option.own},
                {"rate_Hz", kRates_Hz[rate]},
                {"advised", advice.rate == rate && &option == &advice.optionOf(object)},
                {"depth_of_1_N_mm", option.depth_mm()}};
  record.update({{"epsilon_p99_ratio", trial.epsilon_p99()},
                 {"tap_epsilon_p99_ratio", trial.tap.epsilon_p99},
                 {"stroke_epsilon_p99_ratio", trial.stroke.epsilon_p99},
                 {"wrong_side_ticks", trial.stroke.wrongSideTicks},
                 {"limit_cycle_um", trial.worstCycle_um},
                 {"steady", trial.steady},
                 {"pass", trial.good()}});
  const MaterialOption& advised = advice.optionOf(object);
  if (const std::string step = object.stepBetween(advised, option); !step.empty()) {
    record.update({{"step", step},
                   {"depth_of_1_N_step_mm", option.depth_mm() - advised.depth_mm()},
                   {"damping_step_Ns_per_m", option.damping_Ns_per_m - advised.damping_Ns_per_m}});
  }
  return record;
}

Record rateRecord(const SceneAdvice& advice, std::size_t rate, const DevicePreset& device) {
  const RateSummary at = summaryAt(advice, rate, device);
  Record record{{"method", "ours"},
                {"scene", "all objects"},
                {"rate_Hz", kRates_Hz[rate]},
                {"advised", advice.rate == rate},
                {"epsilon_p99_ratio", at.epsilon_p99},
                {"fails", at.fails},
                {"limit_cycle_um", at.worstCycle_um},
                {"unsteady", at.unsteady},
                {"passive_to_N_per_m", at.passiveTo_N_per_m},
                {"processor_ratio", at.core_ratio},
                {"pass", at.good()}};
  if (advice.rate == rate) record["decided_by"] = decidedBy(advice, device);
  const std::size_t advised = advice.rate.value_or(rate);
  if (rate + 1 == advised || rate == advised + 1) {
    record.update({{"step", rate > advised ? "up" : "down"},
                   {"processor_step_ratio", at.core_ratio - summaryAt(advice, advised, device).core_ratio}});
  }
  return record;
}

Record spacingRecord(const ToolAdvice& tool, std::size_t i) {
  const SpacingCandidate& c = tool.candidates[i];
  Record record{
      {"method", "ours"},      {"scene", tool.name},           {"tool", true},      {"spacing_mm", 1e3 * c.spacing_m},
      {"own_spacing", i == 0}, {"advised", i == tool.advised}, {"points", c.points}};
  addDifference(record, c.difference);
  record.update({{"torque_epsilon_p99_ratio", c.torque_p99}, {"hot_tick_p50_ns", c.hot_ns}, {"pass", c.good()}});
  if (i == tool.advised && tool.checked) {
    record.update({{"checked_ticks", tool.checked->difference.ticks},
                   {"checked_epsilon_p99_ratio", tool.checked->difference.epsilon_p99},
                   {"checked_torque_epsilon_p99_ratio", tool.checked->torque_p99}});
  }
  if (i + 1 == tool.advised || i == tool.advised + 1) {
    record.update({{"step", i < tool.advised ? "up" : "down"},
                   {"hot_tick_step_ns", c.hot_ns - tool.candidates[tool.advised].hot_ns}});
  }
  return record;
}

}  // namespace

std::vector<Record> recordsOf(const SceneAdvice& advice, const DevicePreset& device) {
  std::vector<Record> records;
  for (std::size_t i = 0; advice.tool && i < advice.tool->candidates.size(); ++i) {
    records.push_back(spacingRecord(*advice.tool, i));
  }
  for (const ObjectAdvice& object : advice.objects) {
    records.push_back(verdictRecord(object));
    for (const SceneFeature& feature : object.features) records.push_back(featureRecord(object, feature));
    for (const FailureMotion& motion : object.motions) records.push_back(motionRecord(object, motion));
    for (std::size_t i = 0; i < object.candidates.size(); ++i) records.push_back(meshRecord(object, i));
    for (const MaterialOption& option : object.options) {
      for (std::size_t i = 0; i < kRates_Hz.size(); ++i) records.push_back(optionRecord(advice, object, option, i));
    }
  }
  for (std::size_t i = 0; i < kRates_Hz.size(); ++i) records.push_back(rateRecord(advice, i, device));
  return records;
}

}  // namespace haptics::eval
