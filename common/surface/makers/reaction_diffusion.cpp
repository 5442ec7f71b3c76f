#include "common/surface/makers/reaction_diffusion.h"

#include <numbers>
#include <utility>
#include <vector>

#include "common/interruption/interruption.h"
#include "common/surface/lattice.h"
#include "common/surface/makers/computed_field.h"
#include "common/surface/makers/reaction.h"

namespace haptics {
namespace {

constexpr std::uint32_t kPerCell = 8;  ///< Points of the computation along a cell.
constexpr float kReactionStep = 0.3F;  ///< Of time: a quarter of what the diffusion's stability allows.
constexpr int kReactionSteps = 4000;   ///< Growth takes some hundreds; the rest straightens the pattern.

/// One substance, with a column more at either end of a row, so that neighbours need no wrapping there.
class Substance {
 public:
  Substance(std::uint32_t side, Random& random) : side_(side), values_(stride() * side), next_(values_.size()) {
    for (std::size_t y = 0; y < side; ++y) {
      for (std::size_t x = 1; x <= side; ++x) {
        values_[y * stride() + x] = startNear0(random);
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
  const auto delta = deltaFor(kWaveNumber);
  Random random(seed);
  Substance u(side, random), v(side, random);
  std::vector<float> spreadU(side), spreadV(side);
  for (int step = 0; step < kReactionSteps; ++step) {
    interruptionPoint();
    for (std::size_t y = 0; y < side; ++y) {
      u.laplacian(y, spreadU);
      v.laplacian(y, spreadV);
      const float *rowU = u.row(y), *rowV = v.row(y);
      float *nextU = u.nextRow(y), *nextV = v.nextRow(y);
      for (std::size_t x = 0; x < side; ++x) {
        const Substances next = reacted({rowU[x], rowV[x]}, {spreadU[x], spreadV[x]},
                                        {.reaction = reaction, .delta = delta, .step = kReactionStep});
        nextU[x] = next.u;
        nextV[x] = next.v;
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
