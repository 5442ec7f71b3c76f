#include "haptic_server/engine/motion/mass_properties.h"

#include <algorithm>
#include <limits>

#include "common/maths/elementary.h"

namespace haptics {
namespace {

/// Fraction of the largest element by which rounding may break symmetry and the triangle inequality of given values.
constexpr double kRounding = 1e-6;

struct Diagonal {
  Vec3 values;
  glm::dmat3 axes;  // columns, right-handed
};

/// Jacobi's rotations (Golub & Van Loan, 8.5): each clears one element off the diagonal; for three rows four rounds reach
/// rounding.
[[nodiscard]] Diagonal diagonalise(glm::dmat3 a) {
  constexpr int kRounds = 8;
  glm::dmat3 axes(1);
  for (int i = 0; i < 3 * kRounds; ++i) {
    const int p = i % 3;
    const int q = (p + 1) % 3;
    if (a[p][q] == 0) continue;
    // The smaller of the two angles that do: with the larger one the rounds need not converge.
    const double apart = a[q][q] - a[p][p];
    const double angle = 0.5 * elementary::atan2(apart < 0 ? -2 * a[p][q] : 2 * a[p][q], std::abs(apart));
    glm::dmat3 turn(1);
    const auto [sine, cosine] = elementary::sineCosine(angle);
    turn[p][p] = turn[q][q] = cosine;
    turn[q][p] = sine;
    turn[p][q] = -sine;
    a = glm::transpose(turn) * a * turn;
    axes = axes * turn;
  }
  if (glm::determinant(axes) < 0) axes[2] = -axes[2];
  return {{a[0][0], a[1][1], a[2][2]}, axes};
}

[[nodiscard]] bool symmetric(const glm::dmat3& m) {
  double largest = 0;
  for (int i = 0; i < 3; ++i) largest = std::max({largest, std::abs(m[i].x), std::abs(m[i].y), std::abs(m[i].z)});
  for (int i = 0; i < 3; ++i) {
    if (std::abs(m[i][(i + 1) % 3] - m[(i + 1) % 3][i]) > kRounding * largest) return false;
  }
  return true;
}

}  // namespace

MassDefect spreadMass(double mass_kg, Vec3 centre, const glm::dmat3& inertia, MassProperties& properties) {
  if (!std::isfinite(mass_kg) || mass_kg <= 0) return MassDefect::kMass;
  if (!isFinite(centre)) return MassDefect::kCentre;
  for (int i = 0; i < 3; ++i) {
    if (!isFinite(inertia[i])) return MassDefect::kInertia;
  }
  if (!symmetric(inertia)) return MassDefect::kInertia;

  const Diagonal diagonal = diagonalise(inertia);
  const Vec3 m = diagonal.values;
  if (!(std::min({m.x, m.y, m.z}) > 0)) return MassDefect::kInertia;
  if (2 * std::max({m.x, m.y, m.z}) > (m.x + m.y + m.z) * (1 + kRounding)) return MassDefect::kBeyond;
  properties = {mass_kg, centre, glm::normalize(glm::quat_cast(diagonal.axes)), m};
  return MassDefect::kNone;
}

}  // namespace haptics
