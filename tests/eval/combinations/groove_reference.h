#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/maths/vec.h"

namespace haptics::eval {

/// Of two planes that hold the IHIP between them, by the definition of the force: the slope of the least energy, found by
/// search and differences. Nothing of the runtime.
class GrooveReference {
 public:
  struct Side {
    Vec3 normal{0, 0, 1};  ///< Outward, unit.
    double contact_N_per_m = 0;
    double tissue_N_per_m = 0;  ///< 0: rigid.
  };
  using Pair = std::array<double, 2>;

  GrooveReference(const Side& first, const Side& second)
      : side_{first, second}, cosine_(glm::dot(first.normal, second.normal)) {}

  /// What each side presses with, N.
  /// @param below_m  How deep the HIP is below each side.
  [[nodiscard]] Pair pressing_N(const Pair& below_m) const {
    constexpr double kStep_m = 1e-7;
    const Pair yielded = yielded_m(below_m);
    Pair slope_N{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto moved = [&](double by_m) {
        Pair there = below_m;
        there[i] += by_m;
        return energy_J(there, yielded);
      };
      slope_N[i] = (moved(kStep_m) - moved(-kStep_m)) / (2 * kStep_m);
    }
    return slope_N;
  }
  [[nodiscard]] Vec3 force_N(const Pair& below_m) const {
    const Pair pressing = pressing_N(below_m);
    return pressing[0] * side_[0].normal + pressing[1] * side_[1].normal;
  }

 private:
  /// What each normal has of the way from the HIP to both planes.
  [[nodiscard]] Pair parts_m(const Pair& below_m) const {
    const double sine2 = 1 - cosine_ * cosine_;
    return {(below_m[0] - cosine_ * below_m[1]) / sine2, (below_m[1] - cosine_ * below_m[0]) / sine2};
  }

  /// The contact's stiffness towards p goes over from one side's to the other's as cos^2 does, of the angle between them.
  [[nodiscard]] double stiffness_N_per_m(const Vec3& p) const {
    const double apart = std::acos(cosine_);
    const double cosine = std::clamp(glm::dot(p, side_[0].normal) / glm::length(p), std::cos(apart), 1.0);
    const double first = std::cos(std::numbers::pi / 2 * std::acos(cosine) / apart);
    return side_[0].contact_N_per_m * first * first + side_[1].contact_N_per_m * (1 - first * first);
  }

  /// Of the contact's spring and of the tissues, where each side has yielded by so much along its normal.
  [[nodiscard]] double energy_J(const Pair& below_m, const Pair& yielded_m) const {
    const Pair left_m = {below_m[0] - yielded_m[0], below_m[1] - yielded_m[1]};
    const Pair part_m = parts_m(left_m);
    double energy_J = 0;
    if (part_m[0] > 0 && part_m[1] > 0) {
      const Vec3 p = part_m[0] * side_[0].normal + part_m[1] * side_[1].normal;
      energy_J = stiffness_N_per_m(p) * glm::dot(p, p) / 2;
    } else {
      // Which alone holds the IHIP: the other one has no part, and may be nowhere near.
      const std::size_t one = part_m[0] > 0 || (!(part_m[1] > 0) && left_m[0] > 0) ? 0 : 1;
      const double deep_m = std::max(0.0, left_m[one]);
      energy_J = side_[one].contact_N_per_m * deep_m * deep_m / 2;
    }
    for (std::size_t i = 0; i < 2; ++i) energy_J += side_[i].tissue_N_per_m * yielded_m[i] * yielded_m[i] / 2;
    return energy_J;
  }

  /// Where f is least between 0 and a place, by golden section.
  template <class Function>
  [[nodiscard]] static double placeOfLeast(double high, Function f) {
    const double part = (std::sqrt(5.0) - 1) / 2;
    double low = 0;
    constexpr int kSteps = 36;
    for (int i = 0; i < kSteps; ++i) {
      const double left = high - part * (high - low), right = low + part * (high - low);
      (f(left) < f(right) ? high : low) = f(left) < f(right) ? right : left;
    }
    return (low + high) / 2;
  }

  /// How far the sides yield: to the least energy.
  [[nodiscard]] Pair yielded_m(const Pair& below_m) const {
    const double most_m = std::max(0.0, below_m[0]) + std::max(0.0, below_m[1]);
    const auto second = [&](double first) {
      if (!(side_[1].tissue_N_per_m > 0)) return 0.0;
      return placeOfLeast(most_m, [&](double y) { return energy_J(below_m, {first, y}); });
    };
    if (!(side_[0].tissue_N_per_m > 0)) return {0, second(0)};
    const double first = placeOfLeast(most_m, [&](double y) { return energy_J(below_m, {y, second(y)}); });
    return {first, second(first)};
  }

  std::array<Side, 2> side_;
  double cosine_;
};

}  // namespace haptics::eval
