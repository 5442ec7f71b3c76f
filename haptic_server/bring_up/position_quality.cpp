#include "haptic_server/bring_up/position_quality.h"

#include <algorithm>
#include <cmath>

namespace haptics {
namespace {

constexpr double kSame_m = 1e-12;
/// A hand that stops or starts within a millisecond changes by less.
constexpr double kNoHand_m_per_s = 1.5;
/// Of positions farther apart, or closer together, nothing follows.
constexpr std::uint64_t kLongest_ns = 3'000'000, kShortest_ns = 300'000;
constexpr std::size_t kWindow = 64, kEnoughChanges = 10;
constexpr double kSteps = 4;
/// The median of |x[i+1] - 2 x[i] + x[i-1]| of white noise with a standard deviation of 1, 0.6745 sqrt(6).
constexpr double kMedianBend = 1.652;

}  // namespace

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void PositionQuality::addValue(Axis& axis, double moved_m) {
  ++axis.held;
  if (moved_m <= kSame_m) return;
  axis.smallest_m = axis.smallest_m == 0 ? moved_m : std::min(axis.smallest_m, moved_m);
  axis.changes.push_back({moved_m, axis.held});
  axis.held = 0;
}

void PositionQuality::addBend(Axis& axis, double bend_m) {
  axis.bends_m.push_back(std::abs(bend_m));
  if (axis.bends_m.size() < kWindow) return;
  const double noise_m = percentile(std::move(axis.bends_m), 0.5) / kMedianBend;
  axis.bends_m.clear();
  axis.noise_m = axis.judged ? std::min(axis.noise_m, noise_m) : noise_m;
  axis.judged = true;
}

void PositionQuality::add(Vec3 position, std::uint64_t measured_ns) {
  if (!any_) {
    any_ = true;
    low_ = high_ = last_ = position;
    measured_ns_ = measured_ns;
    return;
  }
  const std::uint64_t elapsed_ns = std::max(measured_ns, measured_ns_) - measured_ns_;
  const Vec3 moved = position - last_;
  const bool isRegular = elapsed_ns >= kShortest_ns && elapsed_ns <= kLongest_ns;
  regular_ = isRegular ? regular_ + 1 : 0;
  const Vec3 velocity = isRegular ? moved / (static_cast<double>(elapsed_ns) * 1e-9) : Vec3(0);
  if (regular_ >= 3 && glm::length(velocity - velocity_) > kNoHand_m_per_s) ++glitches_;
  for (int k = 0; k < 3; ++k) {
    Axis& axis = axes_[index(k)];
    addValue(axis, std::abs(moved[k]));
    if (regular_ >= 2) addBend(axis, moved[k] - moved_[k]);
  }
  low_ = glm::min(low_, position);
  high_ = glm::max(high_, position);
  last_ = position;
  moved_ = moved;
  velocity_ = velocity;
  measured_ns_ = measured_ns;
}

double PositionQuality::positionsPerValue(int axis) const {
  const Axis& values = axes_[index(axis)];
  std::vector<double> held;
  for (const Change& change : values.changes) {
    if (change.moved_m >= kSteps * std::max(resolution_m_, values.smallest_m)) held.push_back(change.held);
  }
  return held.size() < kEnoughChanges ? 0 : percentile(std::move(held), 0.5);
}

}  // namespace haptics
