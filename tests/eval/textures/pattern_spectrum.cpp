#include "tests/eval/textures/pattern_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/surface/makers/spot_noise.h"
#include "tests/eval/textures/plane_transform.h"

namespace haptics::eval {
namespace {

/// Calls visit(waves along x, along y, power) for every wave of a field.
template <class Visit>
void visitWaves(const SampledField& field, Visit visit) {
  const std::size_t width = field.width();
  const std::size_t height = field.height();
  const Grid spectrum = transformed(Grid(field.samples().begin(), field.samples().end()), width, height, false);
  const auto waves = [](std::size_t i, std::size_t count) {
    return static_cast<double>(i) - (2 * i > count ? static_cast<double>(count) : 0);
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      if (x + y > 0) visit(waves(x, width), waves(y, height), std::norm(spectrum[y * width + x]));
    }
  }
}

}  // namespace

double ringOf(const SampledField& field) {
  std::vector<double> rings(field.width());
  visitWaves(field, [&](double x, double y, double power) {
    const auto ring = static_cast<std::size_t>(std::lround(std::hypot(x, y)));
    if (ring < rings.size()) rings[ring] += power;
  });
  const auto most = static_cast<std::size_t>(std::max_element(rings.begin(), rings.end()) - rings.begin());
  double sum = 0;
  double weighted = 0;
  for (std::size_t ring = most - std::min<std::size_t>(most, 2); ring <= most + 2; ++ring) {
    sum += rings[ring];
    weighted += rings[ring] * static_cast<double>(ring);
  }
  return weighted / sum;
}

double spotSpectrumDifference(std::uint32_t cells, double elongation, std::uint32_t seed) {
  constexpr std::uint32_t kFields = 64;
  constexpr std::uint32_t kSide = 96;
  constexpr double kRing = 0.5;  // of u
  constexpr std::size_t kRings = 24;
  const double halfWidth = std::sqrt(1 - std::sqrt(0.5));  // of the radius, where (1 - r^2)^2 is a half
  const double radius = 1 / (2 * halfWidth * cells);       // of a tile's side
  std::vector<double> measured(kRings);
  std::vector<double> expected(kRings);
  double measuredAll = 0;
  double expectedAll = 0;
  for (std::uint32_t i = 0; i < kFields; ++i) {
    visitWaves(spotNoise({cells, elongation, kSide, seed + i}), [&](double x, double y, double power) {
      const double u = 2 * std::numbers::pi * radius * std::hypot(x * elongation, y);
      const auto ring = static_cast<std::size_t>(u / kRing);
      if (ring >= kRings) return;
      const double s = std::cyl_bessel_j(3.0, u) / (u * u * u);
      measured[ring] += power;
      expected[ring] += s * s;
      measuredAll += power;
      expectedAll += s * s;
    });
  }
  double difference = 0;
  for (std::size_t i = 0; i < kRings; ++i)
    difference += std::abs(measured[i] / measuredAll - expected[i] / expectedAll);
  return difference;
}

}  // namespace haptics::eval
