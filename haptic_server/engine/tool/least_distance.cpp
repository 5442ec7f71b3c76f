#include "haptic_server/engine/tool/least_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace haptics {
namespace {

/// A normal with its offset.
template <std::size_t kRows>
using Column = std::array<double, kRows>;

/// Squared lengths that are smaller, of columns of length 1 and more, are rounding.
constexpr double kDependent = 1e-18;
/// A half-space that is missed by less holds already.
constexpr double kOptimal = 1e-11;
constexpr int kMaxDistanceRounds = 64;

template <std::size_t kRows>
[[nodiscard]] double dot(const Column<kRows>& a, const Column<kRows>& b) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < kRows; ++i) sum += a[i] * b[i];
  return sum;
}

/// Columns of which a right side is made up, with factors that are not negative.
template <std::size_t kRows>
class PassiveSet {
 public:
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] std::uint32_t index(std::size_t i) const noexcept { return index_[i]; }
  [[nodiscard]] double factor(std::size_t i) const noexcept { return factor_[i]; }
  [[nodiscard]] bool holds(std::uint32_t index) const noexcept {
    return std::find(index_.begin(), index_.begin() + static_cast<std::ptrdiff_t>(count_), index) !=
           index_.begin() + static_cast<std::ptrdiff_t>(count_);
  }

  /// False: it depends on those that are in it.
  [[nodiscard]] bool add(std::uint32_t index, const Column<kRows>& column) noexcept {
    if (count_ == kRows) return false;
    index_[count_] = index;
    column_[count_] = column;
    factor_[count_] = 0;
    if (!orthogonalise(count_)) return false;
    ++count_;
    return true;
  }

  /// Gives the columns the factors that come nearest to (0, ..., 0, 1); those that would be negative leave.
  void fit() noexcept {
    for (;;) {
      const auto best = leastSquares();
      double part = 1;
      std::size_t first = count_;
      for (std::size_t i = 0; i < count_; ++i) {
        if (best[i] > 0) continue;
        const double until = factor_[i] > 0 ? factor_[i] / (factor_[i] - best[i]) : 0;
        if (first == count_ || until < part) {
          part = until;
          first = i;
        }
      }
      for (std::size_t i = 0; i < count_; ++i) factor_[i] += part * (best[i] - factor_[i]);
      if (first == count_) return;
      remove(first);
    }
  }

  /// (0, ..., 0, 1) without what the columns make up.
  [[nodiscard]] Column<kRows> rest() const noexcept {
    Column<kRows> rest{};
    rest[kRows - 1] = 1;
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t k = 0; k < kRows; ++k) rest[k] -= factor_[i] * column_[i][k];
    }
    return rest;
  }

 private:
  std::size_t count_ = 0;
  std::array<std::uint32_t, kRows> index_{};
  std::array<Column<kRows>, kRows> column_{};
  std::array<Column<kRows>, kRows> unit_{};  // orthonormal
  std::array<std::array<double, kRows>, kRows>
      coefficient_{};  // column j = sum over i <= j of coefficient_[j][i] unit i
  std::array<double, kRows> factor_{};

  [[nodiscard]] bool orthogonalise(std::size_t j) noexcept {
    Column<kRows> v = column_[j];
    coefficient_[j] = {};
    const double whole = dot(v, v);
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough (Kahan)
      for (std::size_t i = 0; i < j; ++i) {
        const double along = dot(unit_[i], v);
        coefficient_[j][i] += along;
        for (std::size_t k = 0; k < kRows; ++k) v[k] -= along * unit_[i][k];
      }
    }
    const double left = dot(v, v);
    if (left <= kDependent * whole) return false;
    coefficient_[j][j] = std::sqrt(left);
    for (std::size_t k = 0; k < kRows; ++k) unit_[j][k] = v[k] / coefficient_[j][j];
    return true;
  }

  [[nodiscard]] std::array<double, kRows> leastSquares() const noexcept {
    std::array<double, kRows> best{};
    for (std::size_t j = count_; j-- > 0;) {
      double value = unit_[j][kRows - 1];
      for (std::size_t i = j + 1; i < count_; ++i) value -= coefficient_[i][j] * best[i];
      best[j] = value / coefficient_[j][j];
    }
    return best;
  }

  void remove(std::size_t at) noexcept {
    for (std::size_t i = at; i + 1 < count_; ++i) {
      index_[i] = index_[i + 1];
      column_[i] = column_[i + 1];
      factor_[i] = factor_[i + 1];
    }
    --count_;
    for (std::size_t i = at; i < count_; ++i) {
      if (!orthogonalise(i)) return remove(i);
    }
  }
};

}  // namespace

template <std::size_t kFreedoms>
LeastDistance leastDistance(std::span<const HalfSpace> halfSpaces) noexcept {
  constexpr std::size_t kRows = kFreedoms + 1;
  if (halfSpaces.size() > kMaxHalfSpaces) halfSpaces = halfSpaces.first(kMaxHalfSpaces);
  // In units in which the farthest boundary is at a distance of 1.
  std::array<double, kMaxHalfSpaces> perLength;
  double farthest = 0;
  for (std::size_t i = 0; i < halfSpaces.size(); ++i) {
    double square = 0;
    for (std::size_t k = 0; k < kFreedoms; ++k) square += halfSpaces[i].normal[k] * halfSpaces[i].normal[k];
    perLength[i] = square > 0 ? 1 / std::sqrt(square) : 0;  // one without a normal asks for nothing
    farthest = std::max(farthest, halfSpaces[i].offset * perLength[i]);
  }
  LeastDistance nearest;
  if (farthest <= 0) return nearest;
  const auto column = [&](std::size_t i) noexcept {
    Column<kRows> c;
    for (std::size_t k = 0; k < kFreedoms; ++k) c[k] = halfSpaces[i].normal[k] * perLength[i];
    c[kFreedoms] = halfSpaces[i].offset * perLength[i] / farthest;
    return c;
  };
  PassiveSet<kRows> passive;
  for (int round = 0; round < kMaxDistanceRounds; ++round) {
    const Column<kRows> rest = passive.rest();
    double most = kOptimal;
    std::size_t next = halfSpaces.size();
    for (std::size_t i = 0; i < halfSpaces.size(); ++i) {
      const double missed = dot(column(i), rest);
      if (missed > most && !passive.holds(static_cast<std::uint32_t>(i))) {
        most = missed;
        next = i;
      }
    }
    if (next == halfSpaces.size() || !passive.add(static_cast<std::uint32_t>(next), column(next))) break;
    passive.fit();
  }
  const Column<kRows> rest = passive.rest();
  constexpr double kNothingLeft = 1e-9;
  if (dot(rest, rest) < kNothingLeft * kNothingLeft) {
    nearest.exists = false;
    return nearest;
  }
  for (std::size_t k = 0; k < kFreedoms; ++k) nearest.x[k] = -farthest * rest[k] / rest[kFreedoms];
  nearest.tightCount = static_cast<int>(passive.size());
  for (std::size_t i = 0; i < passive.size(); ++i) {
    nearest.tight[i] = passive.index(i);
    nearest.multiplier[i] = farthest * passive.factor(i) * perLength[passive.index(i)] / rest[kFreedoms];
  }
  return nearest;
}

template LeastDistance leastDistance<6>(std::span<const HalfSpace>) noexcept;
template LeastDistance leastDistance<7>(std::span<const HalfSpace>) noexcept;

}  // namespace haptics
