#include "tests/haptic_server/device/emulated/mechanics.h"

#include <cmath>
#include <numbers>

namespace haptics::test {
namespace {

constexpr std::uint64_t kStep_ns = 50'000;
/// Longer gaps are lost time: nobody watches a device that nothing reads.
constexpr std::uint64_t kLongestGap_ns = 100'000'000;

}  // namespace

Mechanics::Mechanics(const DevicePreset& device) : plant_(device, *findHandPreset("nominal")) {
  plant_.place(intended(0));
}

Vec3 Mechanics::intended(double time_s) {
  const double turn = 2 * std::numbers::pi * time_s;
  return {0.015 * std::sin(turn / 3), 0.015 * std::cos(turn / 4.3), -0.01 + 0.02 * std::cos(turn / 2)};
}

void Mechanics::advance(std::uint64_t now_ns, Vec3 motor_N) {
  if (time_ns_ == 0) time_ns_ = began_ns_ = now_ns;
  if (now_ns > time_ns_ + kLongestGap_ns) {
    began_ns_ += now_ns - time_ns_ - kLongestGap_ns;
    time_ns_ = now_ns - kLongestGap_ns;
  }
  for (; time_ns_ + kStep_ns <= now_ns; time_ns_ += kStep_ns) {
    constexpr double kStep_s = kStep_ns * 1e-9;
    const double time_s = static_cast<double>(time_ns_ - began_ns_) * 1e-9;
    const Vec3 velocity = (intended(time_s + kStep_s) - intended(time_s)) / kStep_s;
    plant_.step(kStep_s, motor_N, {intended(time_s + kStep_s / 2), Vec3(0)}, velocity);
  }
}

}  // namespace haptics::test
