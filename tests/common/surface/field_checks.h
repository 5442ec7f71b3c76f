#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/surface/lattice.h"
#include "common/surface/scalar_field.h"

// What every scalar field promises, checked anywhere in a box around the origin.
namespace haptics::fixture {

inline Vec3 randomPoint(Random& random, double halfSide_m) {
  const auto coordinate = [&] { return halfSide_m * (2 * random.uniform() - 1); };
  const double x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

inline Vec3 randomDirection(Random& random) {
  while (true) {
    const Vec3 v = randomPoint(random, 1);
    if (const double length = glm::length(v); length > 0.1 && length < 1) return v / length;
  }
}

/// By differences of fourth order, whose own error is far below what is asked for.
inline Vec3 differenced(const ScalarField& field, Vec3 point, double step_m) {
  Vec3 gradient(0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](double steps) {
      Vec3 moved = point;
      moved[axis] += steps * step_m;
      return field.at(moved).value;
    };
    gradient[axis] = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step_m);
  }
  return gradient;
}

inline void expectTheGradientIsTheDerivative(const ScalarField& field, double halfSide_m, int points = 2000) {
  Random random(7);
  double steepest = 0, worst = 0;
  for (int i = 0; i < points; ++i) {
    const Vec3 point = randomPoint(random, halfSide_m);
    const Vec3 gradient = field.at(point).gradient;
    steepest = std::max(steepest, glm::length(gradient));
    worst = std::max(worst, glm::length(gradient - differenced(field, point, 1e-4 * field.shortestWavelength_m())));
  }
  EXPECT_GT(steepest, 0);
  EXPECT_LE(worst, 1e-5 * steepest);
}

/// The largest change of the gradient from step to step of straight walks, and of the value.
struct Steps {
  double value = 0, gradient = 0;
};
inline Steps stepsAlong(const ScalarField& field, Vec3 start, Vec3 direction, double step_m, int count) {
  Steps largest;
  FieldSample before = field.at(start);
  for (int i = 1; i <= count; ++i) {
    const FieldSample now = field.at(start + i * step_m * direction);
    largest.value = std::max(largest.value, std::abs(now.value - before.value));
    largest.gradient = std::max(largest.gradient, glm::length(now.gradient - before.gradient));
    before = now;
  }
  return largest;
}

/// Along straight walks of short steps, value and gradient change no faster than the bounds say.
inline void expectNoStepOfValueOrGradient(const ScalarField& field, double halfSide_m, int walks = 40) {
  Random random(11);
  const double step_m = 1e-3 * field.shortestWavelength_m();
  Steps largest;
  for (int walk = 0; walk < walks; ++walk) {
    const Vec3 start = randomPoint(random, halfSide_m);
    const Steps steps = stepsAlong(field, start, randomDirection(random), step_m, 3000);
    largest.value = std::max(largest.value, steps.value);
    largest.gradient = std::max(largest.gradient, steps.gradient);
  }
  EXPECT_LE(largest.value, field.bounds().slope_per_m * step_m);
  EXPECT_LE(largest.gradient, field.bounds().curvature_per_m2 * step_m);
  EXPECT_GT(largest.gradient, 0);
}

/// Across a place, shorter steps change value and gradient by less in proportion: neither jumps there.
inline void expectNoJumpAcross(const ScalarField& field, Vec3 place, Vec3 direction, double reach_m) {
  const auto across = [&](int steps) {
    return stepsAlong(field, place - reach_m * direction, direction, 2 * reach_m / steps, steps);
  };
  const Steps coarse = across(2000), fine = across(20'000);
  EXPECT_GT(coarse.gradient, 0);
  EXPECT_LE(fine.value, 0.15 * coarse.value) << place.x << ' ' << place.y << ' ' << place.z;
  EXPECT_LE(fine.gradient, 0.15 * coarse.gradient) << place.x << ' ' << place.y << ' ' << place.z;
}

struct Extremes {
  double lowest = 1e9, highest = -1e9;
};

/// The most extreme values found: random points, the best of them improved by a climb.
inline Extremes extremesOf(const ScalarField& field, double halfSide_m, int points = 200'000) {
  Random random(13);
  Extremes found;
  for (const double sign : {-1.0, 1.0}) {
    double best = -1e9;
    Vec3 where(0);
    for (int i = 0; i < points; ++i) {
      const Vec3 point = randomPoint(random, halfSide_m);
      if (const double value = sign * field.at(point).value; value > best) {
        best = value;
        where = point;
      }
    }
    for (double step_m = 0.1 * field.shortestWavelength_m(); step_m > 1e-6 * field.shortestWavelength_m();) {
      const Vec3 next = where + step_m * sign * glm::normalize(field.at(where).gradient + Vec3(1e-300));
      if (const double value = sign * field.at(next).value; value > best) {
        best = value;
        where = next;
      } else {
        step_m /= 2;
      }
    }
    (sign < 0 ? found.lowest : found.highest) = sign * best;
  }
  return found;
}

inline void expectToStayWithinBounds(const ScalarField& field, double halfSide_m) {
  const Extremes found = extremesOf(field, halfSide_m);
  EXPECT_GE(found.lowest, field.lowest());
  EXPECT_LE(found.highest, field.highest());
}

}  // namespace haptics::fixture
