#include "tests/eval/stability/limits.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptics::eval {
namespace {

/// State at a tick: position, velocity, last position, and the forces still on their way, the newest first.
Eigen::MatrixXd transition(const SampledLoop& loop, double stiffness) {
  const auto delay = static_cast<Eigen::Index>(std::lround(loop.delay_s / loop.period_s));
  const double t = loop.period_s, m = loop.mass_kg, b = loop.viscousFriction_Ns_per_m;
  // m x'' + b x' = F over a period, exactly.
  const double rate = b / m;
  const double fade = std::exp(-rate * t);
  const double glide = rate > 0 ? (1 - fade) / rate : t;
  const double pushed = rate > 0 ? (1 - fade) / b : t / m;
  const double shifted = rate > 0 ? (t - glide) / b : t * t / (2 * m);
  const double damper = loop.damping_Ns_per_m / t;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 + delay, 3 + delay);
  a(0, 0) = 1;
  a(0, 1) = glide;
  a(1, 1) = fade;
  a(2, 0) = 1;
  const auto force = [&](Eigen::Index row, double gain) {
    a(row, 0) += gain * (-stiffness - damper);
    a(row, 2) += gain * damper;
  };
  if (delay == 0) {
    force(0, shifted);
    force(1, pushed);
    return a;
  }
  a(0, 2 + delay) = shifted;
  a(1, 2 + delay) = pushed;
  force(3, 1);
  for (Eigen::Index i = 1; i < delay; ++i) a(3 + i, 2 + i) = 1;
  return a;
}

bool isStable(const SampledLoop& loop, double stiffness) {
  return transition(loop, stiffness).eigenvalues().cwiseAbs().maxCoeff() <= 1;
}

}  // namespace

double passiveLimit_N_per_m(const SampledLoop& loop) noexcept {
  return 2 * (loop.viscousFriction_Ns_per_m - std::abs(loop.damping_Ns_per_m)) / loop.period_s;
}

double delayLimit_N_per_m(const SampledLoop& loop) noexcept {
  return (loop.viscousFriction_Ns_per_m + loop.damping_Ns_per_m) / (loop.period_s / 2 + loop.delay_s);
}

double exactLimit_N_per_m(const SampledLoop& loop) {
  constexpr double kMin_N_per_m = 0.1;  // below, the eigenvalue of the free mass is too near the circle to tell
  constexpr int kHalvings = 60;
  if (!isStable(loop, kMin_N_per_m)) return 0;
  double stable = kMin_N_per_m, unstable = kMin_N_per_m;
  do unstable *= 1.1;
  while (isStable(loop, unstable));
  stable = unstable / 1.1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (stable + unstable) / 2;
    (isStable(loop, middle) ? stable : unstable) = middle;
  }
  return stable;
}

double frictionLimit_N_per_m(double viscousFriction_Ns_per_m, double coulombFriction_N, double step_m,
                             double period_s) noexcept {
  return std::min(2 * viscousFriction_Ns_per_m / period_s, 2 * coulombFriction_N / step_m);
}

double localRadius_m(const SampledLoop& loop, double coulombFriction_N, double stiffness_N_per_m) noexcept {
  const double made = stiffness_N_per_m * loop.period_s / 2 - loop.viscousFriction_Ns_per_m;
  const double frequency = std::sqrt(stiffness_N_per_m / loop.mass_kg);
  return 4 * coulombFriction_N / (std::numbers::pi * frequency * made);
}

}  // namespace haptics::eval
