#include "haptic_server/simplification/force_difference.h"

#include <algorithm>

#include "common/maths/perception.h"

namespace haptics {

ForceDifference differenceOf(const std::vector<Forces>& felt, const std::vector<Forces>& truth) {
  ForceDifference difference;
  std::vector<double> errors;
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
      errors.push_back(forceError_jnd(felt_N, truth_N));
      feltTicks += errors.back() >= 1 ? 1 : 0;
      missing = shouldTouch && !touching && glm::length(truth_N) > kMinForceThreshold_N ? missing + 1 : 0;
      difference.missedTicks += missing > 1 ? 1 : 0;
      difference.wrongSideTicks += glm::dot(felt_N, truth_N) < 0 ? 1 : 0;
    }
  }
  if (errors.empty()) return difference;
  std::ranges::sort(errors);
  difference.epsilon_p99 = errors[static_cast<std::size_t>(0.99 * static_cast<double>(errors.size() - 1))];
  difference.epsilon_max = errors.back();
  difference.felt_ratio = static_cast<double>(feltTicks) / difference.ticks;
  return difference;
}

}  // namespace haptics
