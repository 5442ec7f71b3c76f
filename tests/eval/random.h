#pragma once

#include <cstdint>
#include <numbers>
#include <random>

#include "common/maths/vec.h"

namespace haptics::eval {

/// Numbers that a seed fixes on every machine: the standard's distributions differ between libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  [[nodiscard]] double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  [[nodiscard]] int below(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  [[nodiscard]] bool chance(double share) { return between(0, 1) < share; }
  [[nodiscard]] double sign() { return below(2) == 0 ? 1.0 : -1.0; }
  [[nodiscard]] Vec3 direction() {
    const double z = between(-1, 1);
    const double angle = between(0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  [[nodiscard]] Quat rotation() { return glm::angleAxis(between(0, std::numbers::pi), direction()); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace haptics::eval
