#include "haptic_server/engine/step/groove_springs.h"

#include <algorithm>
#include <numbers>

#include "common/maths/elementary.h"

namespace haptics {

/// Where a vector lies between two normals.
struct GrooveSprings::Between {
  double apart;  ///< A.
  double angle;  ///< a, 0 to A.
  Vec3 across;   ///< Unit, the way in which a grows.

  Between(Vec3 first, Vec3 second, Vec3 p) noexcept {
    const Vec3 aside = second - first * glm::dot(first, second);
    const double sine = glm::length(aside);
    apart = elementary::atan2(sine, glm::dot(first, second));
    angle = std::clamp(elementary::atan2(glm::dot(p, aside) / sine, glm::dot(p, first)), 0.0, apart);
    const auto [ofAngle, cosine] = elementary::sineCosine(angle);
    across = aside / sine * cosine - first * ofAngle;
  }
  [[nodiscard]] double ofQuarter() const noexcept { return std::numbers::pi / 2 * angle / apart; }
  [[nodiscard]] double secondWeight() const noexcept {
    const double sine = elementary::sin(ofQuarter());
    return sine * sine;
  }
  /// The share of the second term.
  [[nodiscard]] double part() const noexcept {
    const double of = std::min(1.0, apart / kMinAngle);
    return of * of;
  }
};

std::array<std::size_t, 2> GrooveSprings::apart() const noexcept {
  for (std::size_t first = 0; first < count_; ++first) {
    for (std::size_t second = first + 1; second < count_; ++second) {
      const double cosine = glm::dot(normal_[first], normal_[second]);
      if (!(1 - cosine * cosine < kMinSquaredSine)) return {first, second};
    }
  }
  return {0, 0};
}

Vec3 GrooveSprings::force_N(Vec3 p) const noexcept {
  const auto springs = spring_N_per_m_.begin();
  const auto [one, other] = apart();
  if (one == other || std::all_of(springs, springs + count_, [&](double k) { return k == spring_N_per_m_[0]; }))
    return spring_N_per_m_[0] * p;
  if (one + other > 1) return stiffness_N_per_m(p) * p;  // the first two are as one: no part of the second term
  const Between first(normal_[0], normal_[1], p);
  if (count_ == 2) {
    const double more_N_per_m = spring_N_per_m_[1] - spring_N_per_m_[0];
    const double slope_N_per_m =
        more_N_per_m * elementary::sin(2 * first.ofQuarter()) * std::numbers::pi / 2 / first.apart;
    return (spring_N_per_m_[0] + more_N_per_m * first.secondWeight()) * p +
           first.part() * slope_N_per_m / 2 * glm::length(p) * first.across;
  }
  const double part =
      std::min({first.part(), Between(normal_[1], normal_[2], p).part(), Between(normal_[2], normal_[0], p).part()});
  constexpr double kStep = 1e-4;  // of |p|
  Vec3 slope_N_per_m(0);
  const double step_m = kStep * glm::length(p);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 aside_m(0);
    aside_m[axis] = step_m;
    slope_N_per_m[axis] = (stiffness_N_per_m(p + aside_m) - stiffness_N_per_m(p - aside_m)) / (2 * kStep);
  }
  return stiffness_N_per_m(p) * p + part / 2 * glm::length(p) * slope_N_per_m;
}

double GrooveSprings::stiffness_N_per_m(Vec3 p) const noexcept {
  const auto weight = weights(p);
  double sum = 0;
  for (std::size_t i = 0; i < count_; ++i) sum += weight[i] * spring_N_per_m_[i];
  return sum;
}

std::array<double, ContactState::kMaxHolding> GrooveSprings::weights(Vec3 p) const noexcept {
  const auto [one, other] = apart();
  if (one == other) return {1, 0, 0};
  std::array<double, ContactState::kMaxHolding> ofTwo{};
  ofTwo[other] = Between(normal_[one], normal_[other], p).secondWeight();
  ofTwo[one] = 1 - ofTwo[other];
  if (count_ == 2) return ofTwo;
  const double volume = glm::dot(normal_[0], glm::cross(normal_[1], normal_[2]));
  std::array<double, 3> squared;  // of p's distance from the plane of the two others' normals
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 others = glm::cross(normal_[(i + 1) % 3], normal_[(i + 2) % 3]);
    const double length = glm::length(others);
    const double distance = length > 0 ? glm::dot(p, others) / length : 0;
    squared[i] = distance * distance;
  }
  std::array<double, 3> nearness;  // one over the square, times all three
  for (std::size_t i = 0; i < 3; ++i) nearness[i] = squared[(i + 1) % 3] * squared[(i + 2) % 3];
  const double sum = nearness[0] + nearness[1] + nearness[2];
  if (volume * volume < kMinSquaredSine || !(sum > 0)) return ofTwo;
  std::array<double, 3> weight{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t first = (i + 1) % 3, second = (i + 2) % 3;
    const double ofSecond = Between(normal_[first], normal_[second], p).secondWeight();
    weight[first] += nearness[i] / sum * (1 - ofSecond);
    weight[second] += nearness[i] / sum * ofSecond;
  }
  return weight;
}

}  // namespace haptics
