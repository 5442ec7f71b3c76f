#include "common/surface/makers/reaction_diffusion.h"

#include <numbers>
#include <utility>
#include <vector>

#include "common/surface/lattice.h"
#include "common/surface/makers/computed_field.h"

namespace haptics {
namespace {

// du/dt = D delta lap(u) + alpha u (1 - r1 v^2) + v (1 - r2 u)
// dv/dt = delta lap(v) + beta v (1 + alpha r1 / beta u v) + gamma u + r2 u v   (Barrio et al. 1999, Eq. (3))
constexpr float kAlpha = 0.899F, kBeta = -0.91F, kGamma = -0.899F, kD = 0.516F;
/// delta times the square of the wave number that grows fastest: where the larger eigenvalue of
/// [alpha - D x, 1; gamma, beta - x] is the largest.
constexpr double kFastest = 0.39676;
constexpr std::uint32_t kPerCell = 8;  ///< Points of the computation along a cell.
constexpr float kStep = 0.3F;          ///< Of time: a quarter of what the diffusion's stability allows.
constexpr int kSteps = 4000;           ///< Growth takes some hundreds; the rest straightens the pattern.
constexpr double kStart = 0.1;         ///< Width of the random start around 0, which is the even state.

struct Reaction {
  float r1, r2;  ///< Third order, which makes stripes; second order, which makes spots.
};
Reaction reactionFor(ReactionDiffusionSource::Pattern pattern) {
  return pattern == ReactionDiffusionSource::Pattern::kStripes ? Reaction{3.5F, 0} : Reaction{0.5F, 0.3F};
}

/// One substance, with a column more at either end of a row, so that neighbours need no wrapping there.
class Substance {
 public:
  Substance(std::uint32_t side, Random& random) : side_(side), values_(stride() * side), next_(values_.size()) {
    for (std::size_t y = 0; y < side; ++y) {
      for (std::size_t x = 1; x <= side; ++x) {
        values_[y * stride() + x] = static_cast<float>(kStart * (random.uniform() - 0.5));
      }
      wrap(values_, y);
    }
  }

  [[nodiscard]] const float* row(std::size_t y) const { return values_.data() + y * stride() + 1; }
  [[nodiscard]] float* nextRow(std::size_t y) { return next_.data() + y * stride() + 1; }
  void endRow(std::size_t y) { wrap(next_, y); }
  void endStep() { values_.swap(next_); }

  /// Laplacian of a row by the nine-point stencil, whose error is the same in all directions.
  void laplacian(std::size_t y, std::vector<float>& result) const {
    const float *below = row((y + side_ - 1) % side_), *here = row(y), *above = row((y + 1) % side_);
    float* out = result.data();
    for (std::ptrdiff_t x = 0; x < side_; ++x) {
      const float beside = here[x - 1] + here[x + 1] + below[x] + above[x];
      const float across = below[x - 1] + below[x + 1] + above[x - 1] + above[x + 1];
      out[x] = (4 * beside + across - 20 * here[x]) * (1 / 6.0F);
    }
  }

 private:
  std::ptrdiff_t side_;
  std::vector<float> values_, next_;

  [[nodiscard]] std::size_t stride() const { return static_cast<std::size_t>(side_) + 2; }
  void wrap(std::vector<float>& values, std::size_t y) const {
    float* row = values.data() + y * stride();
    row[0] = row[side_];
    row[side_ + 1] = row[1];
  }
};

/// The first substance once the pattern stands, side * side.
std::vector<float> grown(std::uint32_t side, Reaction reaction, std::uint32_t seed) {
  constexpr double kWaveNumber = 2 * std::numbers::pi / kPerCell;
  const auto delta = static_cast<float>(kFastest / (kWaveNumber * kWaveNumber));
  const auto [r1, r2] = reaction;
  Random random(seed);
  Substance u(side, random), v(side, random);
  std::vector<float> spreadU(side), spreadV(side);
  for (int step = 0; step < kSteps; ++step) {
    for (std::size_t y = 0; y < side; ++y) {
      u.laplacian(y, spreadU);
      v.laplacian(y, spreadV);
      const float *rowU = u.row(y), *rowV = v.row(y);
      float *nextU = u.nextRow(y), *nextV = v.nextRow(y);
      for (std::size_t x = 0; x < side; ++x) {
        const float a = rowU[x], b = rowV[x];
        const float cubic = kAlpha * r1 * a * b * b, quadratic = r2 * a * b;
        nextU[x] = a + kStep * (kD * delta * spreadU[x] + kAlpha * a - cubic + b - quadratic);
        nextV[x] = b + kStep * (delta * spreadV[x] + kBeta * b + cubic + kGamma * a + quadratic);
      }
      u.endRow(y);
      v.endRow(y);
    }
    u.endStep();
    v.endStep();
  }
  std::vector<float> pattern;
  for (std::size_t y = 0; y < side; ++y) pattern.insert(pattern.end(), u.row(y), u.row(y) + side);
  return pattern;
}

}  // namespace

SampledField reactionDiffusion(const ReactionDiffusionSource& source) {
  const std::uint32_t side = kPerCell * source.cells;
  const SampledField coarse =
      SampledField::make(side, side, grown(side, reactionFor(source.pattern), source.seed)).value();
  const double scale = static_cast<double>(side) / source.resolution;
  std::vector<double> values;
  values.reserve(std::size_t{source.resolution} * source.resolution);
  for (std::uint32_t y = 0; y < source.resolution; ++y) {
    for (std::uint32_t x = 0; x < source.resolution; ++x) values.push_back(coarse.at(x * scale, y * scale).value);
  }
  return zeroMeanField(source.resolution, values);
}

}  // namespace haptics
