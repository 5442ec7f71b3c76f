#include "tests/eval/fuzz/contact_tally.h"

#include <algorithm>

namespace haptics::eval {

std::string_view nameOf(ContactFailure failure) {
  switch (failure) {
    case ContactFailure::kInside:
      return "inside";
    case ContactFailure::kCrossing:
      return "crossing";
    case ContactFailure::kNotFinite:
      return "not-finite";
    case ContactFailure::kAside:
      return "aside";
  }
  return "";
}

std::optional<ContactFailure> ContactRule::apply(const ContactVerdict& verdict, const ContactWork& work) {
  insideInARow_ = verdict.inside_m > 0 ? insideInARow_ + 1 : 0;
  if (!verdict.finite) return ContactFailure::kNotFinite;
  if (insideInARow_ > 1 || (insideInARow_ == 1 && !work.depenetrated)) return ContactFailure::kInside;
  if (verdict.crossed && (!work.depenetrated || verdict.hadRoom)) return ContactFailure::kCrossing;
  if (verdict.aside_m > kFeltAside_m && !work.allowanceSpent) return ContactFailure::kAside;
  return std::nullopt;
}

void ContactTally::add(const ContactResult& result, const ContactVerdict& verdict, std::int64_t insideInARow,
                       double duration_ns) {
  const ContactWork& work = result.work;
  ++ticks_;
  touching_ += result.touching ? 1 : 0;
  inside_ += insideInARow > 0 ? 1 : 0;
  insideNotDepenetrated_ += insideInARow > 0 && !work.depenetrated ? 1 : 0;
  episodes_ += insideInARow == 1 ? 1 : 0;
  longestEpisode_ = std::max(longestEpisode_, insideInARow);
  depenetrated_ += work.depenetrated ? 1 : 0;
  notConverged_ += work.notConverged ? 1 : 0;
  crossings_ += verdict.crossed && !work.depenetrated ? 1 : 0;
  crossingsDepenetrated_ += verdict.crossed && work.depenetrated ? 1 : 0;
  notFinite_ += verdict.finite ? 0 : 1;
  (work.allowanceSpent ? asideWaiting_ : aside_) += verdict.aside_m > kFeltAside_m ? 1 : 0;
  waiting_ += work.allowanceSpent ? 1 : 0;
  deepest_m_ = std::max(deepest_m_, verdict.inside_m);
  maxTriangles_ = std::max(maxTriangles_, work.triangles);
  maxSegments_ = std::max(maxSegments_, work.segments);
  maxSolverRounds_ = std::max(maxSolverRounds_, work.solverRounds);
  maxSteps_ = std::max(maxSteps_, work.steps);
  durations_.add(duration_ns);
}

Record ContactTally::record() const {
  constexpr double kMillimetres = 1e3;
  return {{"scenes", scenes_},
          {"failed_scenes", failedScenes_},
          {"ticks", ticks_},
          {"contact_ticks", touching_},
          {"inside_ticks", inside_},
          {"inside_not_depenetrated_ticks", insideNotDepenetrated_},
          {"inside_episodes", episodes_},
          {"longest_episode_ticks", longestEpisode_},
          {"deepest_mm", deepest_m_ * kMillimetres},
          {"depenetrated_ticks", depenetrated_},
          {"not_converged_ticks", notConverged_},
          {"sheet_crossings", crossings_},
          {"sheet_crossings_depenetrated", crossingsDepenetrated_},
          {"nan_ticks", notFinite_},
          {"aside_ticks", aside_},
          {"aside_waiting_ticks", asideWaiting_},
          {"waiting_ticks", waiting_},
          {"most_triangles", maxTriangles_},
          {"most_segments", maxSegments_},
          {"most_solver_rounds", maxSolverRounds_},
          {"most_steps", maxSteps_},
          {"tick_p50_ns", durations_.quantile_ns(0.5)},
          {"tick_p99.9_ns", durations_.quantile_ns(0.999)},
          {"tick_max_ns", durations_.largest_ns()},
          {"pass", failedScenes_ == 0}};
}

}  // namespace haptics::eval
