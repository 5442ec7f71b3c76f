#include "tests/eval/stability/critical.h"

#include <cmath>

namespace haptics::eval {

Settling restOf(const Loop& loop, double stiffness_N_per_m) {
  const double period_s = 1 / loop.rate_Hz;
  const Rendering told{loop.ground,       loop.toldDevice != nullptr ? *loop.toldDevice : loop.device,
                       period_s,          std::max(0.0, loop.delay_s + loop.toldDelayMore_s),
                       stiffness_N_per_m, loop.damping_Ns_per_m};
  Settling worst{0, true};
  for (const PressKind& kind : pressKinds()) {
    const auto method = loop.method->make(told);
    const Settling rest = restUnder(*method, *loop.ground,
                                    {loop.device, loop.hand, period_s, loop.delay_s, kind.force_N, kind.tap_m_per_s});
    worst.cycle_m = std::max(worst.cycle_m, rest.cycle_m);
    worst.steady = worst.steady && rest.steady;
    if (!worst.steady) return worst;
  }
  return worst;
}

double criticalStiffness_N_per_m(const Loop& loop, const Search& search) {
  double stable = 0;
  double unstable = search.least_N_per_m;
  while (unstable <= search.most_N_per_m && restOf(loop, unstable).steady) {
    stable = unstable;
    unstable *= search.climb;
  }
  if (stable == 0 || unstable > search.most_N_per_m) return stable;
  while (unstable / stable > search.close) {
    const double middle = std::sqrt(stable * unstable);
    (restOf(loop, middle).steady ? stable : unstable) = middle;
  }
  return stable;
}

}  // namespace haptics::eval
