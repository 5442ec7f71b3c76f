#pragma once

// Laws of effects as tests have them: computed another way than by the engine.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "haptic_server/engine/effects/effect_field.h"

namespace haptics::effect_laws {

using Kind = Effect::Kind;
constexpr double kPeriod_s = 1e-3;
constexpr int kStates = 100'000;
constexpr double kClose_N = 1e-9;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Vec3 unit() {
    for (;;) {
      const Vec3 v = vector(1);
      if (glm::length(v) > 0.1) return glm::normalize(v);
    }
  }
  bool chance() { return number(0, 1) < 0.5; }
  /// A walk of so many points.
  std::vector<Vec3> path(int points) {
    std::vector<Vec3> path{vector(0.05)};
    for (int i = 1; i < points; ++i) path.push_back(path.back() + number(0.001, 0.01) * unit());
    return path;
  }

 private:
  std::mt19937 engine_;
};

/// 3 t^2 - 2 t^3 on the way inside.
inline double smooth(double inside, double fade) {
  if (inside <= 0) return 0;
  if (fade == 0 || inside >= fade) return 1;
  return 3 * std::pow(inside / fade, 2) - 2 * std::pow(inside / fade, 3);
}

inline Vec3 atMost(Vec3 force, double limit) {
  const double length = glm::length(force);
  return limit > 0 && length > limit ? force / length * limit : force;
}

inline Effect randomSpring(Kind kind, Random& random) {
  Effect effect{.kind = kind};
  effect.point_m = random.vector(0.05);
  effect.direction = random.unit();
  effect.stiffness_N_per_m = random.number(10, 2000);
  effect.damping_Ns_per_m = random.chance() ? random.number(0, 5) : 0;
  if (random.chance()) effect.limit_N = random.number(0.1, 5);
  if (random.chance()) {
    effect.reach_m = random.number(0.01, 0.1);
    if (random.chance()) effect.release_m = effect.reach_m * random.number(1, 2);
    if (random.chance()) effect.fade_m = effect.reach_m * random.number(0.01, 1);
  }
  return effect;
}

/// @param far  From the HIP to the target.
/// @param damped  The velocity that the damper sees.
inline Vec3 springLaw(const Effect& effect, Vec3 far, Vec3 damped, bool held) {
  double weight = 1;
  if (effect.reach_m > 0) {
    const double release = std::max(effect.reach_m, effect.release_m), r = glm::length(far);
    if (r >= (held ? release : effect.reach_m)) return Vec3(0);
    weight = smooth(release - r, effect.fade_m);
  }
  return weight * atMost(effect.stiffness_N_per_m * far - effect.damping_Ns_per_m * damped, effect.limit_N);
}

/// Round a loop of two sines in each direction; where the nearest place leaps, the step is halved down to it.
inline double workRound(const std::function<Vec3(Vec3)>& forceAt, const std::array<Vec3, 5>& loop) {
  const auto place = [&](double s) {
    Vec3 x = loop[0];
    for (std::size_t k = 1; k <= 2; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) * s;
      x += loop[2 * k - 1] * std::cos(angle) + loop[2 * k] * std::sin(angle);
    }
    return x;
  };
  struct Felt {
    double s;
    Vec3 place, force;
  };
  const auto felt = [&](double s) {
    const Vec3 x = place(s);
    return Felt{s, x, forceAt(x)};
  };
  const std::function<double(const Felt&, const Felt&)> work = [&](const Felt& from, const Felt& to) {
    const Vec3 way = to.place - from.place;
    if (glm::distance(from.force, to.force) * glm::length(way) > 2e-6 && glm::length(way) > 1e-12) {
      const Felt between = felt((from.s + to.s) / 2);
      return work(from, between) + work(between, to);
    }
    return glm::dot((from.force + to.force) / 2.0, way);
  };
  constexpr int kSteps = 200;
  Felt from = felt(0);
  double sum_J = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Felt to = felt(static_cast<double>(i + 1) / kSteps);
    sum_J += work(from, to);
    from = to;
  }
  return sum_J;
}

}  // namespace haptics::effect_laws
