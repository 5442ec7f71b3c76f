#include "tests/eval/stability/press.h"

#include <algorithm>
#include <array>
#include <limits>

#include "haptic_server/device/simulated_device.h"
#include "tests/eval/extent.h"

namespace haptics::eval {
namespace {

constexpr double kWindow_s = 0.3;
/// A tap bounces for seconds where little friction takes its energy: judged once it is at rest, or when it has stopped
/// getting smaller.
constexpr int kFewestWindows = 7;
constexpr int kMostWindows = 30;
constexpr int kWindowsBack = 6;
constexpr double kShrinking = 0.97;
constexpr double kLeastCycle_m = 20e-6;
constexpr double kTapHeight_m = 1e-3;
constexpr double kStrike_s = 2e-3;
/// Nobody brings a device back that was thrown so far; nothing that comes to rest gets there.
constexpr double kThrown_m = 0.05;

/// Presses along -z with a constant force, by its spring where it has one; is struck down first for a tap.
class PressingHand final : public HandIntent {
 public:
  PressingHand(const Press& press, Vec3 place) : start_{place, Vec3(0)}, pressing_{place, Vec3(0)} {
    start_.position.z += press.tap_m_per_s > 0 ? kTapHeight_m : press.device.resolution_m;
    if (press.hand.stiffness_N_per_m > 0) {
      pressing_.position.z -= press.force_N / press.hand.stiffness_N_per_m;
    } else {
      pressing_.push_N.z = -press.force_N;
    }
    if (press.tap_m_per_s > 0) {
      const double mass_kg = press.device.apparentMass_kg + press.hand.mass_kg;
      strike_N_.z = -(mass_kg * press.tap_m_per_s / kStrike_s + press.device.coulombFriction_N);
    }
  }
  HandTarget next(double dt_s, Vec3 /*felt_N*/) noexcept override {
    if (dt_s == 0) return start_;
    HandTarget now = pressing_;
    if (time_s_ < kStrike_s) now.push_N += strike_N_;
    time_s_ += dt_s;
    return now;
  }

 private:
  HandTarget start_;
  HandTarget pressing_;
  Vec3 strike_N_{0};
  double time_s_ = 0;
};

}  // namespace

Settling restUnder(StabilityMethod& method, const Ground& ground, const Press& press) {
  PressingHand hand(press, ground.place);
  SimulatedDevice device({press.device, press.hand, press.period_s, press.delay_s}, hand);
  const auto ticks = static_cast<std::uint64_t>(kWindow_s / press.period_s);
  constexpr double kRounding = 1 + 1e-6;
  const double allowed_m = kRounding * std::max(2 * press.device.resolution_m, kLeastCycle_m);
  std::array<double, kMostWindows> cycle_m{};
  std::uint64_t tick = 0;
  for (std::size_t window = 0; window < kMostWindows; ++window) {
    Extent extent;
    for (const std::uint64_t end = tick + ticks; tick < end; ++tick) {
      device.write(method.tick(device.read(tick).position));
      const Vec3 place = device.plant().position();
      if (glm::distance(place, ground.place) > kThrown_m) return {kThrown_m, false};
      extent.add(place);
    }
    cycle_m[window] = extent.longest_m();
    if (window + 1 < kFewestWindows) continue;
    if (cycle_m[window] <= allowed_m) return {cycle_m[window], true};
    if (cycle_m[window] > kShrinking * cycle_m[window - kWindowsBack]) return {cycle_m[window], false};
  }
  return {cycle_m.back(), false};
}

const std::vector<PressKind>& pressKinds() {
  static const std::vector<PressKind> kinds{{0.5, 0}, {1, 0}, {0.5, 0.02}, {0.5, 0.15}};
  return kinds;
}

}  // namespace haptics::eval
