#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>

#include "common/surface/cellular_field.h"
#include "common/surface/grain_field.h"
#include "common/surface/noise_field.h"
#include "field_checks.h"

namespace haptics::lattice_fields_test {
namespace {

using namespace fixture;

constexpr double kSide_m = 0.003;
constexpr double kHalf_m = 0.1;

struct Case {
  std::string name;
  std::shared_ptr<const ScalarField> field;
};

/// Fields on a lattice of random numbers, each promised to be continuous everywhere.
class LatticeField : public ::testing::TestWithParam<Case> {
 protected:
  const ScalarField& field() const { return *GetParam().field; }
};

TEST_P(LatticeField, HasTheGradientOfItsValue) { expectTheGradientIsTheDerivative(field(), kHalf_m); }

TEST_P(LatticeField, HasNoStepOfValueOrGradient) { expectNoStepOfValueOrGradient(field(), kHalf_m); }

TEST_P(LatticeField, StaysWithinItsBounds) { expectToStayWithinBounds(field(), kHalf_m); }

TEST_P(LatticeField, IsFiniteFarFromTheOrigin) {
  for (const double far_m : {1e-12, 1.0, 1e3, 1e6}) {
    const FieldSample sample = field().at({far_m, -far_m, 0.5 * far_m});
    EXPECT_TRUE(std::isfinite(sample.value) && isFinite(sample.gradient)) << far_m;
  }
}

std::string nameOf(const ::testing::TestParamInfo<Case>& each) { return each.param.name; }

template <class Field, class Family>
std::shared_ptr<const ScalarField> make(const Family& family) {
  return std::make_shared<const Field>(family);
}

INSTANTIATE_TEST_SUITE_P(Each, LatticeField,
                         ::testing::Values(Case{"Noise", make<NoiseField>(NoiseFamily{kSide_m})},
                                           Case{"FractalNoise", make<NoiseField>(NoiseFamily{kSide_m, 5, 0.6, 9})},
                                           Case{"Grain", make<GrainField>(GrainFamily{kSide_m})},
                                           Case{"SharpCells", make<CellularField>(CellularFamily{kSide_m, 0.02})},
                                           Case{"Cells", make<CellularField>(CellularFamily{kSide_m})},
                                           Case{"SoftCells", make<CellularField>(CellularFamily{kSide_m, 0.5})}),
                         nameOf);

TEST(NoiseField, ReachesItsBoundWhereACellsGradientsAreTheBestForOnePlace) {
  // Perlin's noise with the gradients to choose: at each place the best are the edges' directions nearest to the way.
  double highest = 0;
  constexpr int kSteps = 60;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      for (int k = 0; k <= kSteps; ++k) {
        const Vec3 at = Vec3(i, j, k) / static_cast<double>(kSteps);
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3 from(corner & 1, corner >> 1 & 1, corner >> 2);
          const Vec3 way = glm::abs(at - from);
          double weight = 1;
          for (int axis = 0; axis < 3; ++axis) weight *= fade(1 - way[axis]).value;
          sum += weight * (way.x + way.y + way.z - std::min({way.x, way.y, way.z}));
        }
        highest = std::max(highest, sum);
      }
    }
  }
  EXPECT_NEAR(highest, 1.0363538, 1e-3);
  const Extremes found = extremesOf(NoiseField(NoiseFamily{kSide_m}), kHalf_m, 2'000'000);
  EXPECT_GT(found.highest, 0.9);
  EXPECT_LT(found.lowest, -0.9);
}

TEST(NoiseField, IsZeroOnItsLatticeAndNowhereOnAWholePlane) {
  const NoiseField field(NoiseFamily{kSide_m});
  EXPECT_NEAR(field.at(Vec3(0)).value, 0, 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    int zeros = 0;
    for (int i = 1; i < 100; ++i) {
      Vec3 point(0);
      point[axis] = i * kSide_m;
      zeros += std::abs(field.at(point).value) < 1e-3;
    }
    EXPECT_LE(zeros, 3) << axis;
  }
}

/// Perlin's noise without its gradient and without a shared step: each corner's ramp times its weight.
double plainNoise(const CellLattice::Place& place) {
  constexpr std::array<std::array<int, 3>, 12> kEdges{{{1, 1, 0},
                                                       {-1, 1, 0},
                                                       {1, -1, 0},
                                                       {-1, -1, 0},
                                                       {1, 0, 1},
                                                       {-1, 0, 1},
                                                       {1, 0, -1},
                                                       {-1, 0, -1},
                                                       {0, 1, 1},
                                                       {0, -1, 1},
                                                       {0, 1, -1},
                                                       {0, -1, -1}}};
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> step{corner & 1, corner >> 1 & 1, corner >> 2};
    const auto& edge = kEdges[(CellLattice::bits(place.key, step[0], step[1], step[2]) >> 32) * 12 >> 32];
    double ramp = 0, weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double way = place.within[axis] - step[axis];
      const double near = 1 - std::abs(way);
      ramp += edge[axis] * way;
      weight *= near * near * near * (6 * near * near - 15 * near + 10);
    }
    sum += weight * ramp;
  }
  return sum;
}

TEST(NoiseField, IsPerlinsNoise) {
  const NoiseField field(NoiseFamily{kSide_m, 1, 0.5, 4});
  const CellLattice lattice(kSide_m, Random(4).bits());
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 point = randomPoint(random, kHalf_m);
    EXPECT_NEAR(field.at(point).value, plainNoise(lattice.place(point)) / 1.0363538112, 1e-9);
  }
}

TEST(NoiseField, OfManyOctavesHasTheirVariancesInPersistencesProportion) {
  const auto variance = [](const NoiseFamily& family) {
    const NoiseField field(family);
    Random random(1);
    double squares = 0;
    constexpr int kPoints = 100'000;
    for (int i = 0; i < kPoints; ++i) {
      const double value = field.at(randomPoint(random, kHalf_m)).value;
      squares += value * value / kPoints;
    }
    return squares;
  };
  const double one = variance({kSide_m, 1, 0.5, 4});
  // Independent octaves of amplitude 1, 1/2 and 1/4, divided by the sum of them.
  EXPECT_NEAR(variance({kSide_m, 3, 0.5, 4}) / one, (1 + 0.25 + 0.0625) / (1.75 * 1.75), 0.01);
  EXPECT_DOUBLE_EQ(NoiseField({kSide_m, 3, 0.5, 4}).shortestWavelength_m(), kSide_m / 4);
}

TEST(GrainField, HasMean0AndVariance1AtEveryPlaceOfItsLattice) {
  // At the origin, which is a lattice point, and on the way to the neighbouring points.
  constexpr int kSeeds = 60'000;
  for (const Vec3 point : {Vec3(0), Vec3(0.25, 0.1, 0), Vec3(0.4, 0.5, 0.45), Vec3(0.6, -0.3, 0.8)}) {
    double sum = 0, squares = 0;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const double value = GrainField({kSide_m, seed}).at(kSide_m * point).value;
      sum += value;
      squares += value * value;
    }
    EXPECT_NEAR(sum / kSeeds, 0, 4 / std::sqrt(kSeeds));
    EXPECT_NEAR(squares / kSeeds, 1, 4 * std::sqrt(2.0 / kSeeds));
  }
}

TEST(GrainField, IsNormallyDistributedUpToItsFlatTops) {
  const GrainField field({kSide_m, 1});
  Random random(2);
  int within1 = 0, within2 = 0, tops = 0;
  constexpr int kPoints = 400'000;
  for (int i = 0; i < kPoints; ++i) {
    const double size = std::abs(field.at(randomPoint(random, 10 * kHalf_m)).value);
    within1 += size < 1;
    within2 += size < 2;
    tops += size > 0.99 * field.highest();
  }
  EXPECT_NEAR(within1, 0.6799 * kPoints, 0.006 * kPoints);
  EXPECT_NEAR(within2, 0.9527 * kPoints, 0.003 * kPoints);
  EXPECT_GT(tops, 0);
}

TEST(GrainField, ForgetsWhatLiesTwoGrainsAway) {
  const GrainField field({kSide_m, 1});
  Random random(3);
  double together = 0;
  constexpr int kPoints = 200'000;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3 point = randomPoint(random, 10 * kHalf_m);
    together += field.at(point).value * field.at(point + 2 * kSide_m * randomDirection(random)).value;
  }
  EXPECT_NEAR(together / kPoints, 0, 0.01);
}

/// Worley's F1 by looking at every point of 5 x 5 x 5 cells, in cells, along with the second nearest.
std::array<double, 2> twoNearest(const CellLattice& lattice, Vec3 point) {
  const CellLattice::Place place = lattice.place(point);
  std::array<double, 2> nearest{9, 9};
  for (int cell = 0; cell < 125; ++cell) {
    const int i = cell % 5 - 2, j = cell / 5 % 5 - 2, k = cell / 25 - 2;
    const std::uint64_t bits = CellLattice::bits(place.key, i, j, k);
    const auto part = [&bits](int which) { return static_cast<double>(bits >> 21 * which & 0x1fffff) / 0x200000; };
    const double d = glm::length(place.within - Vec3(i + part(0), j + part(1), k + part(2)));
    if (d < nearest[0]) {
      nearest = {d, nearest[0]};
    } else {
      nearest[1] = std::min(nearest[1], d);
    }
  }
  return nearest;
}

TEST(CellularField, IsTheDistanceToTheNearestPointWhereNoOtherIsAboutAsNear) {
  const CellularField field({kSide_m, 0.02, 5});
  const CellLattice lattice(kSide_m, 5);
  Random random(6);
  int compared = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 point = randomPoint(random, kHalf_m);
    const auto [first, second] = twoNearest(lattice, point);
    if (second - first < 0.2 || first > 0.8) continue;
    EXPECT_NEAR(field.at(point).value, first, 0.02);
    ++compared;
  }
  EXPECT_GT(compared, 5000);
}

TEST(CellularField, Is0AtItsPointsAnd1WhereNoneIsInReach) {
  const Extremes found = extremesOf(CellularField({kSide_m, 0.05, 5}), kHalf_m, 2'000'000);
  EXPECT_NEAR(found.lowest, 0, 0.01);
  EXPECT_NEAR(found.highest, 1, 0.01);
}

TEST(RandomFields, DifferBySeedAndAreTheSameOnEveryMachine) {
  const Vec3 point(0.0123, -0.0456, 0.0789);
  const auto noise = [&](std::uint32_t seed) { return NoiseField({kSide_m, 2, 0.5, seed}).at(point).value; };
  const auto grain = [&](std::uint32_t seed) { return GrainField({kSide_m, seed}).at(point).value; };
  const auto cells = [&](std::uint32_t seed) { return CellularField({kSide_m, 0.1, seed}).at(point).value; };
  EXPECT_NE(noise(1), noise(2));
  EXPECT_NE(grain(1), grain(2));
  EXPECT_NE(cells(1), cells(2));
  EXPECT_NEAR(noise(1), 0.28700251475695476, 1e-12);
  EXPECT_NEAR(grain(1), 2.1591764641018125, 1e-12);
  EXPECT_NEAR(cells(1), 0.4092397303808793, 1e-12);
}

}  // namespace
}  // namespace haptics::lattice_fields_test
