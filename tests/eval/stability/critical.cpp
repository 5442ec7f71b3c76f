#include "tests/eval/stability/critical.h"

#include <algorithm>
#include <vector>

#include "haptic_server/servo/settling.h"

namespace haptics::eval {
namespace {

bool comesToRestInEveryWay(const Loop& loop, double stiffness_N_per_m) {
  const double period_s = 1 / loop.rate_Hz;
  const Rendering told{loop.ground,       loop.toldDevice != nullptr ? *loop.toldDevice : loop.device,
                       period_s,          std::max(0.0, loop.delay_s + loop.toldDelayMore_s),
                       stiffness_N_per_m, loop.damping_Ns_per_m};
  std::vector<PressTrial> trials;
  for (const PressKind& kind : pressKinds()) {
    const Press press{loop.device, loop.hand, period_s, loop.delay_s, kind.force_N, kind.tap_m_per_s};
    trials.push_back({press, loop.method->make(told)});
  }
  return allComeToRest(trials, loop.ground->place);
}

}  // namespace

double criticalStiffness_N_per_m(const Loop& loop, const StabilitySearch& search) {
  return largestStable(search,
                       [&](double stiffness_N_per_m) { return comesToRestInEveryWay(loop, stiffness_N_per_m); });
}

}  // namespace haptics::eval
