#include "common/surface/point_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/surface/grown_field.h"
#include "common/surface/make_field.h"
#include "common/surface/sampled_field.h"
#include "field_checks.h"

namespace haptics::point_field_test {
namespace {

using namespace fixture;
using ::testing::HasSubstr;

constexpr double kRadius_m = 0.02;
constexpr int kCount = 600;
constexpr float kReach_m = 0.0062F;  // twice the spacing of so many samples on such a sphere

/// Evenly spaced over a sphere, along a spiral.
std::vector<PointSample> onSphere(const std::function<float(Vec3)>& valueAt) {
  std::vector<PointSample> samples;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1 - (2 * i + 1.0) / kCount, across = std::sqrt(1 - z * z);
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
    const Vec3 outward(across * std::cos(turn), across * std::sin(turn), z);
    samples.push_back({Vec3f(kRadius_m * outward) + Vec3f(0), valueAt(outward) + 0.0F});
  }
  return samples;
}

PointField field(const std::function<float(Vec3)>& valueAt) {
  return PointField::make(kReach_m, onSphere(valueAt)).value();
}

PointField noise() {
  return field([random = Random(5)](Vec3) mutable { return static_cast<float>(2 * random.uniform() - 1); });
}

GrownField grownNoise() { return GrownField(std::make_shared<const PointField>(noise())); }

PointField alone(Vec3f at = Vec3f(0), float value = 2) { return PointField::make(1, {{at, value}}).value(); }

Vec3 onSurface(Random& random) { return kRadius_m * randomDirection(random); }

/// By its definition, from all samples.
double reference(const PointField& field, Vec3 point) {
  double weights = 0, moment = 0;
  for (const PointSample& sample : field.samples()) {
    const double part = glm::distance(point, Vec3(sample.point)) / field.reach_m();
    if (part >= 1) continue;
    const double weight = std::pow(1 - part * part, 3);
    weights += weight;
    moment += weight * sample.value;
  }
  const double t = std::min(1.0, weights / 0.5);
  return weights > 0 ? t * t * t * (t * (6 * t - 15) + 10) * moment / weights : 0;
}

TEST(PointField, IsTheWeightedAverageOfAllSamplesWithinReach) {
  const PointField field = noise();
  Random random(3);
  int within = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 point = randomPoint(random, 1.5 * kRadius_m);
    const double value = field.at(point).value;
    EXPECT_NEAR(value, reference(field, point), 1e-12);
    within += value != 0 ? 1 : 0;
  }
  EXPECT_GT(within, 3000);
}

TEST(PointField, HasTheGradientOfItsValue) { expectTheGradientIsTheDerivative(grownNoise(), 1.3 * kRadius_m, 20'000); }

TEST(PointField, JumpsNowhereAlongLongWalksNeitherOnTheSurfaceNorThroughIt) {
  const GrownField field = grownNoise();
  Random random(3);
  for (int walk = 0; walk < 40; ++walk) {
    const Vec3 place = onSurface(random);
    expectNoJumpAcross(field, place, randomDirection(random), 0.005);
    expectNoJumpAcross(field, place, glm::normalize(place), 0.005);
  }
}

TEST(PointField, StaysWithinItsBoundsAndComesNearThem) {
  const GrownField field = grownNoise();
  expectToStayWithinBounds(field, 1.3 * kRadius_m);
  const Extremes found = extremesOf(field, 1.1 * kRadius_m, 1'000'000);
  const double near = 0.02 * (field.highest() - field.lowest());
  EXPECT_LT(found.lowest, field.lowest() + near);
  EXPECT_GT(found.highest, field.highest() - near);
}

TEST(PointField, IsNoSteeperNorMoreCurvedOnItsSurfaceThanItsBoundsSay) {
  const GrownField field = grownNoise();
  Random random(9);
  const double step_rad = 1e-3;
  double slope = 0, curvature = 0;
  for (int walk = 0; walk < 60; ++walk) {
    const Vec3 from = randomDirection(random);
    const Vec3 aside = glm::normalize(glm::cross(from, randomDirection(random)));
    Vec3 before = field.at(kRadius_m * from).gradient;
    for (double turn = step_rad; turn < 1; turn += step_rad) {
      const Vec3 now = field.at(kRadius_m * (std::cos(turn) * from + std::sin(turn) * aside)).gradient;
      slope = std::max(slope, glm::length(now));
      curvature = std::max(curvature, glm::length(now - before) / (step_rad * kRadius_m));
      before = now;
    }
  }
  EXPECT_LE(slope, field.bounds().slope_per_m);
  EXPECT_GT(slope, 0.5 * field.bounds().slope_per_m);
  EXPECT_LE(curvature, 1.1 * field.bounds().curvature_per_m2);
  EXPECT_GT(curvature, 0.4 * field.bounds().curvature_per_m2);
}

TEST(PointField, GivesWhatIsEvenBackAndWhatIsSmoothNearly) {
  const PointField even = field([](Vec3) { return 0.75F; });
  const PointField smooth = field([](Vec3 outward) { return static_cast<float>(outward.x); });
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point = onSurface(random);
    EXPECT_DOUBLE_EQ(even.at(point).value, 0.75);
    EXPECT_LT(glm::length(even.at(point).gradient), 1e-9);
    EXPECT_NEAR(smooth.at(point).value, point.x / kRadius_m, 0.03);
  }
  EXPECT_DOUBLE_EQ(even.bounds().highest, 0.75);
  EXPECT_EQ(even.bounds().lowest, 0) << "as it is away from its samples";
}

TEST(PointField, FadesToNothingAwayFromItsSamples) {
  const PointField field = alone();
  const double whole = std::sqrt(1 - std::cbrt(0.5));  // where (1 - d^2)^3 is kWholeWeight
  double last = 2;
  for (double d = 0; d < 1.2; d += 0.001) {
    const FieldSample sample = field.at({0, 0, d});
    if (d < whole) {
      EXPECT_DOUBLE_EQ(sample.value, 2);
    } else if (d >= 1) {
      EXPECT_EQ(sample.value, 0);
    }
    EXPECT_LE(sample.value, last);
    EXPECT_LE(sample.gradient.z, 1e-12);
    last = sample.value;
  }
  expectNoJumpAcross(GrownField(std::make_shared<const PointField>(field)), {0, 0, 0.7}, {0, 0, 1}, 0.6);
  EXPECT_EQ(field.at({1e6, -1e6, 1e300}).value, 0);
}

TEST(PointField, ShowsHalfOfAWaveOfItsShortestWavelength) {
  // A square of samples, four to the wave; the field's reach is the same with any.
  std::vector<PointSample> samples;
  const double wavelength_m = GrownField(std::make_shared<const PointField>(alone())).shortestWavelength_m();
  constexpr int kHalf = 20;
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x) {
      const double at = wavelength_m * x / 8;
      const auto value = static_cast<float>(std::cos(2 * std::numbers::pi * x / 8));
      samples.push_back({Vec3f(at, wavelength_m * y / 8, 0) + Vec3f(0), value + 0.0F});
    }
  }
  const PointField wave = PointField::make(1, samples).value();
  EXPECT_NEAR(wave.at(Vec3(0)).value, 0.5, 0.03);
  EXPECT_NEAR(wave.at(Vec3(wavelength_m / 2, 0, 0)).value, -0.5, 0.03);
}

// ---- Refusals ----

Error refusal(float reach_m, std::vector<PointSample> samples) {
  const auto made = PointField::make(reach_m, std::move(samples));
  return made ? Error{"accepted", ""} : made.error();
}

TEST(PointField, IsRefusedByTheNumberThatIsWrong) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinite = std::numeric_limits<float>::infinity();
  for (const float reach_m : {0.0F, -1.0F, 1e-7F, 1001.0F, kNan, kInfinite}) {
    EXPECT_EQ(refusal(reach_m, {{Vec3f(0), 0}}).field, "reach_m") << reach_m;
  }
  EXPECT_EQ(refusal(1, {}).field, "count");
  EXPECT_EQ(refusal(1, std::vector<PointSample>(PointField::kMaxSamples + 1)).field, "count");
  for (const float bad : {kNan, kInfinite, -kInfinite, 1001.0F, -0.0F}) {
    for (int axis = 0; axis < 3; ++axis) {
      PointSample sample;
      sample.point[axis] = bad;
      EXPECT_EQ(refusal(1, {{}, sample}).field, "samples[1].point") << bad;
    }
    EXPECT_EQ(refusal(1, {{}, {}, {Vec3f(0), bad}}).field, "samples[2].value") << bad;
  }
}

TEST(PointField, IsRefusedWhereALookUpWouldTakeLongOrMuchMemory) {
  const std::vector<PointSample> most(NearSamples::kMaxNear, PointSample{});
  EXPECT_EQ(refusal(1, most).field, "accepted");
  std::vector<PointSample> dense = most;
  dense.push_back({Vec3f(0.5F, 0, 0), 0});
  EXPECT_EQ(refusal(1, dense).field, "samples");
  EXPECT_THAT(refusal(1, dense).reason, HasSubstr("at most 512"));
  EXPECT_THAT(refusal(1e-4F, {{}, {Vec3f(0, 0, 1000), 0}}).reason, HasSubstr("times the reach"));
  EXPECT_EQ(refusal(1e-3F, {{}, {Vec3f(0, 0, 1000), 0}}).field, "accepted");
  std::vector<PointSample> sparse;
  for (int i = 0; i < 40'000; ++i) {
    sparse.push_back({Vec3f(static_cast<float>(i % 200), static_cast<float>(i / 200), 0), 1});
  }
  EXPECT_THAT(refusal(0.1F, sparse).reason, HasSubstr("farther apart than their reach"));
}

TEST(MakeField, FindsAPointFieldByItsHashAlsoInALayer) {
  const auto points = std::make_shared<const PointField>(alone());
  const ContentHash hash{{1, 2, 3}};
  const FieldLookup none = [](const ContentHash&) { return nullptr; };
  const PointFieldLookup lookup = [&](const ContentHash& wanted) { return wanted == hash ? points : nullptr; };
  EXPECT_EQ(makeField(GrownFamily{hash}, none, lookup).value()->at(Vec3(0)).value, 2);
  const LayeredFamily layers{LayeredFamily::Combination::kSum, {{3, GrownFamily{hash}}, {5, GrownFamily{hash}}}};
  EXPECT_EQ(makeField(layers, none, lookup).value()->at(Vec3(0)).value, 16);
  EXPECT_EQ(makeField(GrownFamily{ContentHash{{9}}}, none, lookup).error().field, "grown");
  EXPECT_EQ(makeField(GrownFamily{hash}, none).error().field, "grown");
}

}  // namespace
}  // namespace haptics::point_field_test
