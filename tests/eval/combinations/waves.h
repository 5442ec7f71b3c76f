#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "common/surface/fourier_field.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// A sum of cosines as its record describes it (common/scene/surface_properties.h), evaluated term by term.
struct Waves {
  std::vector<FourierTerm> terms;

  [[nodiscard]] double value(Vec3 place) const {
    double sum = 0;
    for (const FourierTerm& t : terms) sum += t.amplitude * std::cos(phase(t, place));
    return sum;
  }
  /// 1/m.
  [[nodiscard]] Vec3 gradient(Vec3 place) const {
    Vec3 sum(0);
    for (const FourierTerm& t : terms)
      sum -= t.direction * (t.amplitude * std::sin(phase(t, place)) * 2 * std::numbers::pi / t.wavelength_m);
    return sum;
  }
  /// As the runtime evaluates it.
  [[nodiscard]] std::shared_ptr<const ScalarField> field() const {
    return std::make_shared<const FourierField>(FourierFamily{terms});
  }

 private:
  [[nodiscard]] static double phase(const FourierTerm& t, Vec3 place) {
    return 2 * std::numbers::pi * glm::dot(place, t.direction) / t.wavelength_m + t.phase_rad;
  }
};

/// So many of the same amplitude, 1 altogether.
[[nodiscard]] inline Waves randomWaves(Random& random, int count, double shortest_m, double longest_m) {
  Waves waves;
  for (int i = 0; i < count; ++i) {
    const Vec3 direction = random.direction();
    const double wavelength_m = random.between(shortest_m, longest_m);
    waves.terms.push_back({1.0 / count, direction, wavelength_m, random.between(0, 2 * std::numbers::pi)});
  }
  return waves;
}

}  // namespace haptics::eval
