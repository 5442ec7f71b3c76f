#include "haptic_server/engine/contact/plane_set.h"

#include <algorithm>

namespace haptics {
namespace {

/// Squared sine of the angle under which two planes count as parallel, 1e-6 rad: one of them is enough, and the point
/// where they meet would be noise. Larger lets blunt wedges slip; smaller sends the IHIP far along them.
constexpr double kParallel = 1e-12;

}  // namespace

bool PlaneSet::holds(Vec3 x, double slack) const noexcept {
  return std::all_of(planes_.begin(), planes_.begin() + count_,
                     [&](const ConstraintPlane& plane) { return glm::dot(plane.normal, x) >= plane.offset - slack; });
}

/// x = h + sum of pressure_i n_i on all candidate planes at once, by elimination on their Gram matrix.
bool PlaneSet::solve(Vec3 h, Nearest& candidate) const noexcept {
  constexpr std::size_t kMax = ContactState::kMaxHolding;
  const auto count = static_cast<std::size_t>(candidate.tightCount);
  std::array<std::array<double, kMax + 1>, kMax> gram;
  for (std::size_t i = 0; i < count; ++i) {
    const ConstraintPlane& plane = (*this)[candidate.tight[i]];
    for (std::size_t j = 0; j < count; ++j) gram[i][j] = glm::dot(plane.normal, (*this)[candidate.tight[j]].normal);
    gram[i][count] = plane.offset - glm::dot(plane.normal, h);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (gram[i][i] < kParallel) return false;
    for (std::size_t row = 0; row < count; ++row) {
      if (row == i) continue;
      const double factor = gram[row][i] / gram[i][i];
      for (std::size_t j = i; j <= count; ++j) gram[row][j] -= factor * gram[i][j];
    }
  }
  std::array<double, kMax> pressure;
  candidate.point = h;
  for (std::size_t i = 0; i < count; ++i) {
    pressure[i] = gram[i][count] / gram[i][i];
    if (!(pressure[i] >= 0)) return false;  // it would pull: released
    candidate.point += (*this)[candidate.tight[i]].normal * pressure[i];
  }
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t j = i; j > 0 && pressure[j] > pressure[j - 1]; --j) {
      std::swap(pressure[j], pressure[j - 1]);
      std::swap(candidate.tight[j], candidate.tight[j - 1]);
    }
  }
  return true;
}

std::optional<PlaneSet::Nearest> PlaneSet::nearest(Vec3 h, double slack) const noexcept {
  Nearest candidate{h, 0, {}};
  if (count_ == 0) return candidate;
  const int newest = count_ - 1;
  const auto accept = [&](int count, int second, int third) {
    candidate.tightCount = count;
    candidate.tight = {newest, second, third};
    return solve(h, candidate) && holds(candidate.point, slack);
  };
  if (accept(1, 0, 0)) return candidate;
  for (int second = 0; second < newest; ++second) {
    if (accept(2, second, 0)) return candidate;
  }
  for (int second = 0; second < newest; ++second) {
    for (int third = second + 1; third < newest; ++third) {
      if (accept(3, second, third)) return candidate;
    }
  }
  return std::nullopt;
}

}  // namespace haptics
