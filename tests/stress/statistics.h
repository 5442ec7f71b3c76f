#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace haptics::stress {

/// The value that a share q (0 to 1) of the values does not exceed (nearest rank); 0 when there are none.
[[nodiscard]] inline double percentile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Whether two Poisson counts, over exposures `ta` and `tb`, can be of one rate: the exact two-sided conditional test
/// (given the sum, one count is binomial). 1 where there is nothing to tell apart.
[[nodiscard]] inline double poissonP(std::uint64_t a, double ta, std::uint64_t b, double tb) {
  const std::uint64_t n = a + b;
  if (n == 0 || ta <= 0 || tb <= 0) return 1;
  const double share = ta / (ta + tb);
  const auto logProbability = [&](std::uint64_t k) {
    const auto x = static_cast<double>(k), all = static_cast<double>(n);
    return std::lgamma(all + 1) - std::lgamma(x + 1) - std::lgamma(all - x + 1) + x * std::log(share) +
           (all - x) * std::log1p(-share);
  };
  constexpr double kRounding = 1e-9;
  const double observed = logProbability(a) + kRounding;
  double p = 0;
  for (std::uint64_t k = 0; k <= n; ++k) {
    if (const double one = logProbability(k); one <= observed) p += std::exp(one);
  }
  return std::min(1.0, p);
}

}  // namespace haptics::stress
