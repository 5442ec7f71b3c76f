#include "common/surface/makers/grown_reaction_diffusion.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "common/interruption/interruption.h"
#include "common/surface/makers/even_samples.h"
#include "common/surface/makers/reaction.h"

namespace haptics {
namespace {

constexpr double kPerWavelength = 7;  ///< Samples along a wavelength: fewer do not show a spot's shape.
constexpr double kExchange = 2;       ///< Spacings within which samples exchange: 13 neighbours on average.
constexpr double kReach = 2;          ///< Spacings within which samples have a part in the field's values.
/// About two spots; with fewer there is no pattern.
constexpr double kMinSamples = 100;
constexpr float kGrowthStep = 0.4F;  ///< Of time: a third of what the diffusion's stability allows.
constexpr int kGrowthSteps = 3000;   ///< Growth takes some hundreds; the rest evens the pattern out.
constexpr double kFlat = 0.05;       ///< Less than this above and below the mean is no pattern, where it is about 1.

using Pattern = ReactionDiffusionSource::Pattern;

std::string digits(double number) {
  std::ostringstream text;
  text.precision(3);
  text << number;
  return text.str();
}

tl::unexpected<Error> badWavelength(const std::string& reason) {
  return refused("reaction_diffusion.wavelength_m", reason);
}

double wavelengthFor(double samples, double area_m2) noexcept {
  return kPerWavelength * std::sqrt(2 * area_m2 / (std::numbers::sqrt3 * samples));
}

/// J_0(x), by its power series: true to 1e-6 up to x = 4.
double besselJ0(double x) noexcept {
  double term = 1, sum = 1;
  for (int i = 1; i <= 12; ++i) {
    term *= -x * x / (4.0 * i * i);
    sum += term;
  }
  return sum;
}

/// Spots lie in a hexagonal grid, whose waves are shorter than the distance between neighbours.
double waveNumberOf(const GrownReactionDiffusionSource& source) noexcept {
  const double wave_m =
      source.pattern == Pattern::kSpots ? std::numbers::sqrt3 / 2 * source.wavelength_m : source.wavelength_m;
  return 2 * std::numbers::pi / wave_m;
}

/// Discrete Laplacian: lap(u)_i = sum over its neighbours of w_ij (u_j - u_i), w symmetric.
struct Diffusion {
  struct Share {
    std::uint32_t sample;
    float weight;
  };
  std::vector<std::size_t> first;
  std::vector<Share> shares;

  /// Both substances at once, which the compiler does not find by itself: a third of the growth's time.
  [[nodiscard]] Substances laplacian(const std::vector<Substances>& at, std::size_t i) const noexcept {
    using Pair = float __attribute__((vector_size(sizeof(Substances))));
    const auto pairAt = [&](std::size_t sample) { return std::bit_cast<Pair>(at[sample]); };
    const Pair here = pairAt(i);
    Pair sum{0, 0};
    for (std::size_t n = first[i]; n < first[i + 1]; ++n) {
      sum += shares[n].weight * (pairAt(shares[n].sample) - here);
    }
    return std::bit_cast<Substances>(sum);
  }
};

/// Weights (1 - (d / radius)^2)^2, all scaled so that on average over samples and directions a wave of the wave number k
/// has the Laplacian -k^2 times itself, as on a plane: neighbours at a distance d give J_0(k d) - 1.
Diffusion diffusionBetween(const Neighborhoods& near, double radius_m, double waveNumber) {
  Diffusion diffusion{near.first, {}};
  double sum = 0;
  for (const auto& [sample, distance_m] : near.all) {
    const double part = distance_m / radius_m;
    const double weight = (1 - part * part) * (1 - part * part);
    sum += weight * (1 - besselJ0(waveNumber * distance_m));
    diffusion.shares.push_back({sample, static_cast<float>(weight)});
  }
  const double scale = waveNumber * waveNumber * static_cast<double>(near.first.size() - 1) / sum;
  for (auto& share : diffusion.shares) share.weight = static_cast<float>(share.weight * scale);
  return diffusion;
}

std::vector<Substances> grown(const Diffusion& diffusion, const ReactionStep& step, std::uint32_t seed) {
  Random random(mixed(seed));
  std::vector<Substances> now(diffusion.first.size() - 1), next(now.size());
  for (Substances& at : now) {
    at.u = startNear0(random);
    at.v = startNear0(random);
  }
  for (int i = 0; i < kGrowthSteps; ++i) {
    interruptionPoint();
    for (std::size_t s = 0; s < now.size(); ++s) next[s] = reacted(now[s], diffusion.laplacian(now, s), step);
    now.swap(next);
  }
  return now;
}

/// The first substance, mean 0, scaled to reach 1 or -1; nothing where there is no pattern.
std::vector<double> scaled(const std::vector<Substances>& pattern) {
  double mean = 0, largest = 0;
  for (const Substances& at : pattern) mean += at.u;
  mean /= static_cast<double>(pattern.size());
  for (const Substances& at : pattern) largest = std::max(largest, std::abs(at.u - mean));
  std::vector<double> values;
  if (!(largest > kFlat)) return values;
  for (const Substances& at : pattern) values.push_back((at.u - mean) / largest);
  return values;
}

}  // namespace

double samplesToGrow(const GrownReactionDiffusionSource& source, double area_m2) noexcept {
  const double over = wavelengthFor(kMinSamples, area_m2) / source.wavelength_m;
  return kMinSamples * over * over;
}

Result<PointField> grownReactionDiffusion(const TriMesh& mesh, const GrownReactionDiffusionSource& source) {
  const auto isFar = [](Vec3f v) {
    return glm::any(glm::greaterThan(glm::abs(v), Vec3f(PointField::kMaxCoordinate_m)));
  };
  if (std::ranges::any_of(mesh.vertices, isFar)) {
    return refused("reaction_diffusion", "is of a mesh that reaches farther than " +
                                             digits(PointField::kMaxCoordinate_m) +
                                             " m from its origin; give a smaller one");
  }
  const double area_m2 = areaOf_m2(mesh);
  const double longest_m = wavelengthFor(kMinSamples, area_m2);
  const double shortest_m = wavelengthFor(PointField::kMaxSamples, area_m2);
  const double wanted = samplesToGrow(source, area_m2);
  const std::string takes = "is " + digits(source.wavelength_m) + " m, which takes " + digits(wanted) +
                            " samples of this mesh's " + digits(area_m2) + " m^2; ";
  if (source.wavelength_m < shortest_m) {
    return badWavelength(takes + "at most " + std::to_string(PointField::kMaxSamples) + " are taken: give " +
                         digits(1.01 * shortest_m) + " m or more");
  }
  if (source.wavelength_m > longest_m) {
    return badWavelength(takes + "with less than " + digits(kMinSamples) + " there is no pattern: give " +
                         digits(0.99 * longest_m) + " m or less");
  }
  const auto count = static_cast<std::size_t>(wanted);
  const double spacing_m = evenSpacing_m(area_m2, count);
  const auto samples = evenSamples(mesh, count, source.seed);
  if (!samples) return badWavelength(samples.error().reason + "; give a shorter one");
  const auto near = neighborhoodsOf(*samples, kExchange * spacing_m);
  if (!near) return badWavelength(near.error().reason + "; give a shorter one");

  const double waveNumber = waveNumberOf(source);
  const Diffusion diffusion = diffusionBetween(*near, kExchange * spacing_m, waveNumber);
  const ReactionStep step{reactionFor(source.pattern), deltaFor(waveNumber), kGrowthStep};
  const std::vector<double> values = scaled(grown(diffusion, step, source.seed));
  if (values.empty())
    return badWavelength("is " + digits(source.wavelength_m) +
                         " m, with which no pattern grows on this mesh; give a shorter one");
  std::vector<PointSample> points;
  for (std::size_t i = 0; i < samples->size(); ++i) {
    // -0 + 0 is +0
    points.push_back({Vec3f((*samples)[i].point) + Vec3f(0), static_cast<float>(values[i]) + 0.0F});
  }
  auto field = PointField::make(static_cast<float>(kReach * spacing_m), std::move(points));
  if (!field) return badWavelength("is too long for this mesh, whose samples " + field.error().reason);
  return field;
}

}  // namespace haptics
