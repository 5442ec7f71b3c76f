#pragma once

#include <cmath>

namespace haptics {

/// How closely, as a ratio of neighbouring values: a search first climbs by `climb`, then halves down to `close`.
struct StabilitySearch {
  double least = 0, most = 0;
  double climb = 1.3;
  double close = 1.05;
};

/// Search over stiffness, in N/m.
inline constexpr StabilitySearch kStiffnessSearch{.least = 50, .most = 200e3};

/// Largest value up to which every one that was tried is stable; 0 when the least is not. Searches alike try the same
/// values: of one that asks for more, the result is never larger.
template <class IsStable>
[[nodiscard]] double largestStable(const StabilitySearch& search, IsStable isStable) {
  double stable = 0;
  double unstable = search.least;
  while (unstable <= search.most && isStable(unstable)) {
    stable = unstable;
    unstable *= search.climb;
  }
  if (stable == 0 || unstable > search.most) return stable;
  while (unstable / stable > search.close) {
    const double middle = std::sqrt(stable * unstable);
    (isStable(middle) ? stable : unstable) = middle;
  }
  return stable;
}

}  // namespace haptics
