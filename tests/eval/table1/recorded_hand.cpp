#include "tests/eval/table1/recorded_hand.h"

#include <cmath>
#include <numbers>

namespace haptics::eval {

RecordedHand::RecordedHand() {
  constexpr int kRounds = 8;
  const auto onCircle = [](double angle, double above) {
    return Vec3(tablePathHeight_m() + above, kTablePathRadius_m * std::cos(angle),
                kTablePathRadius_m * std::sin(angle));
  };
  constexpr double kLift_m = 2 * kTableDepth_m;
  const int steps = static_cast<int>(std::ceil(kLift_m / kStep_m));
  for (int i = 0; i < steps; ++i) places_.push_back(onCircle(0, kLift_m * (1 - static_cast<double>(i) / steps)));
  const int ticks = static_cast<int>(std::ceil(2 * std::numbers::pi * kTablePathRadius_m / kStep_m));
  for (int i = 0; i < kRounds * ticks; ++i) places_.push_back(onCircle(2 * std::numbers::pi * i / ticks, 0));
  for (int i = 0; i < steps; ++i) places_.push_back(onCircle(0, kLift_m * i / steps));
}

}  // namespace haptics::eval
