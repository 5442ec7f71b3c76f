#include "tests/eval/advise/force_difference.h"

#include "tests/eval/perception.h"
#include "tests/eval/statistics.h"

namespace haptics::eval {

ForceDifference differenceOf(const std::vector<Forces>& felt, const std::vector<Forces>& truth) {
  ForceDifference difference;
  Statistics epsilons;
  int feltTicks = 0;
  for (std::size_t stroke = 0; stroke < felt.size(); ++stroke) {
    int missing = 0;  // on end
    for (std::size_t i = 0; i < felt[stroke].size(); ++i) {
      const Vec3 felt_N = felt[stroke][i];
      const Vec3 truth_N = truth[stroke][i];
      const bool touching = felt_N != Vec3(0);
      const bool shouldTouch = truth_N != Vec3(0);
      if (!touching && !shouldTouch) continue;
      ++difference.ticks;
      epsilons.add(epsilon(felt_N, truth_N));
      feltTicks += epsilons.last() >= 1 ? 1 : 0;
      missing = shouldTouch && !touching && glm::length(truth_N) > kMinForceThreshold_N ? missing + 1 : 0;
      difference.missedTicks += missing > 1 ? 1 : 0;
      difference.wrongSideTicks += glm::dot(felt_N, truth_N) < 0 ? 1 : 0;
    }
  }
  difference.epsilon_p99 = epsilons.quantile(0.99);
  difference.epsilon_max = epsilons.max();
  difference.felt_ratio = difference.ticks > 0 ? static_cast<double>(feltTicks) / difference.ticks : 0;
  return difference;
}

}  // namespace haptics::eval
