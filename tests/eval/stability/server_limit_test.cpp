// What the server takes surfaces to bear, against what `haptic_eval stability` finds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/stiffness_limit.h"
#include "tests/eval/stability/critical.h"

namespace haptics::eval::server_limit_test {
namespace {

class IdleHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
};

double criticalInHand(const DevicePreset& device, const char* hand, double rate_Hz, double delay_s) {
  static const TestSurface wall = makeWall();
  return criticalStiffness_N_per_m(
      {&stabilityMethods().back(), &wall, device, findHandPreset(hand).value(), rate_Hz, delay_s});
}

void expectHalfAtMost(const DevicePreset& device, double rate_Hz, double delay_s) {
  IdleHand idle;
  const DeviceInfo info = SimulatedDevice({device, HandPreset{}, 1 / rate_Hz, delay_s}, idle).info();
  const double limit = kStabilityMargin * criticalStiffness_N_per_m(info, rate_Hz, true);
  const double inNobodysHand = criticalInHand(device, "none", rate_Hz, delay_s);
  const double inLightHand = criticalInHand(device, "light", rate_Hz, delay_s);
  std::printf("%-12s %6.0f Hz %4.1f ms: server's limit %7.0f N/m; stability, nobody's hand %7.0f, light hand %7.0f\n",
              device.name.data(), rate_Hz, delay_s * 1e3, limit, inNobodysHand, inLightHand);
  EXPECT_GT(limit, 0);
  EXPECT_LE(limit, 0.5 * std::min(inNobodysHand, inLightHand)) << device.name << ' ' << rate_Hz << ' ' << delay_s;
}

constexpr double kDelays_s[] = {0, 0.5e-3, 1e-3, 2e-3};

TEST(ServerLimit, IsAtMostHalfOfWhatStabilityFindsOnTheDefaultDeviceAndOthers) {
  for (const char* device : {"omni", "desktop", "falcon"}) {
    for (const double delay_s : kDelays_s) expectHalfAtMost(findDevicePreset(device).value(), 1000, delay_s);
  }
}

TEST(ServerLimit, IsAtMostHalfOfWhatStabilityFindsEverywhere) {
  if (std::getenv("HAPTICS_LONG") == nullptr) GTEST_SKIP() << "takes minutes: set HAPTICS_LONG";
  for (const DevicePreset& device : devicePresets()) {
    for (const double rate_Hz : {1e3, 2e3, 4e3, 10e3}) {
      for (const double delay_s : kDelays_s) expectHalfAtMost(device, rate_Hz, delay_s);
    }
  }
}

}  // namespace
}  // namespace haptics::eval::server_limit_test
