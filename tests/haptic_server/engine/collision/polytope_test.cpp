#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics::test::polytope_test {
namespace {

using testing::Each;
using testing::Field;
using testing::Gt;
using testing::SizeIs;

std::optional<Polytope> polytopeOf(const TriMesh& mesh) {
  return haptics::polytopeOf(*buildCollisionMesh(mesh.vertices, mesh.triangles));
}
Polytope box(Vec3 size_m, int segments = 1) { return polytopeOf(makeBox(size_m, segments).value()).value(); }
Pose at(Vec3 place, Quat turn = {1, 0, 0, 0}) { return {turn, place}; }

TEST(Polytope, OfABoxHasItsSidesHoweverFineItsMeshIs) {
  for (const int segments : {1, 7, 40}) {
    const Polytope made = box({0.06, 0.03, 0.02}, segments);
    EXPECT_THAT(made.faces, SizeIs(6));
    EXPECT_THAT(made.corners, SizeIs(8));
    EXPECT_THAT(made.edges, SizeIs(12));
    EXPECT_THAT(made.directions, SizeIs(3));
  }
}

TEST(Polytope, IsAbsentWhereAMeshIsOpenOrBentInward) {
  TriMesh open = makeBox(Vec3(0.02), 1).value();
  open.triangles.pop_back();
  EXPECT_FALSE(polytopeOf(open));
  TriMesh dented = makeBox(Vec3(0.02), 2).value();
  for (Vec3f& v : dented.vertices) {
    if (glm::length(glm::vec2(v)) < 1e-6f && v.z > 0) v.z = 0.005f;  // the middle of its top
  }
  EXPECT_FALSE(polytopeOf(dented));
}

std::optional<Polytope> hullOf(const TriMesh& mesh) {
  return haptics::hullOf(*buildCollisionMesh(mesh.vertices, mesh.triangles));
}
TriMesh stretched(TriMesh mesh, Vec3f by) {
  for (Vec3f& v : mesh.vertices) v *= by;
  return mesh;
}

TEST(Polytope, OfARoundMeshIsAHullThatIsNearlyTheMesh) {
  constexpr double kRadius_m = 0.01;
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  for (const std::uint32_t segments : {8U, 16U, 32U}) {
    const Polytope hull = hullOf(makeSphere(kRadius_m, segments).value()).value();
    EXPECT_FALSE(hull.hasFew());
    Polytope::Corner near = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 at = kRadius_m * glm::normalize(Vec3(normal(engine), normal(engine), normal(engine)));
      const double height_m = hull.above(at, near).height_m;
      EXPECT_GE(height_m, -1e-9);
      EXPECT_LE(height_m, (kHullError + 0.005) * kRadius_m) << "the mesh itself is as much smaller than the ball";
    }
  }
  TriMesh grooved = makeSphere(kRadius_m, 16).value();
  for (Vec3f& v : grooved.vertices) v *= std::abs(v.z) < 1e-3F ? 0.98F : 1.0F;
  EXPECT_FALSE(hullOf(grooved));
}

/// The judge tries other planes: none may part the two by more.
TEST(Polytopes, ThatAreRoundTouchAlongTheAxisThatPartsThemBest) {
  struct Depth {
    double deep_m, better_m;
  };
  constexpr std::array kDepths{Depth{0, 5e-6}, Depth{0.0015, 250e-6}};
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return glm::normalize(Vec3(normal(engine), normal(engine), normal(engine))); };
  const std::array shapes{hullOf(makeSphere(0.008, 12).value()).value(), box({0.011, 0.009, 0.008}),
                          hullOf(stretched(makeSphere(0.008, 16).value(), {2, 0.7F, 1})).value(),
                          polytopeOf(makeCylinder(0.006, 0.02, 48).value()).value()};
  for (const Polytope& a : shapes) {
    for (const Polytope& b : shapes) {
      if (a.hasFew() && b.hasFew()) continue;
      for (int i = 0; i < 20; ++i) {
        const Quat turn = glm::normalize(Quat(normal(engine), normal(engine), normal(engine), normal(engine)));
        const Vec3 away = direction();
        double in = 0, out = 0.06;
        for (int step = 0; step < 40; ++step) {
          const double middle = (in + out) / 2;
          (contactOf(a, b, at(middle * away, turn), {.range_m = 0.06}).gap_m > 0 ? out : in) = middle;
        }
        for (const auto& [deep_m, better_m] : kDepths) {
          const Pose pose = at((out - deep_m) * away, turn);
          const PolytopeContact contact = contactOf(a, b, pose, {.range_m = 1e-4});
          ASSERT_GT(contact.count, 0U);
          const auto gapAlong = [&](Vec3 n) {
            double first = 1, second = -1;
            for (const Vec3 corner : a.corners) first = std::min(first, glm::dot(n, toWorld(pose, corner)));
            for (const Vec3 corner : b.corners) second = std::max(second, glm::dot(n, corner));
            return first - second;
          };
          EXPECT_NEAR(gapAlong(contact.normal), contact.gap_m, 5e-6);
          double most = 0;
          for (int n = 0; n < 200; ++n) {
            const double bend = n < 100 ? 0.3 : 0.03;
            most = std::max(most, gapAlong(glm::normalize(contact.normal + bend * direction())) - contact.gap_m);
          }
          EXPECT_LE(most, better_m);
        }
      }
    }
  }
}

TEST(Polytopes, TouchWhereTheFacesThatLieOnEachOtherOverlap) {
  const PolytopeContact contact =
      contactOf(box({0.02, 0.02, 0.02}), box({0.1, 0.1, 0.02}), at({0.045, 0, 0.01999}), {.range_m = 1e-4});
  EXPECT_NEAR(contact.normal.z, 1, 1e-12);
  EXPECT_NEAR(contact.gap_m, -1e-5, 1e-9);
  double least = 1, most = -1;
  for (const auto& point : contact.all()) {
    least = std::min(least, point.on.x);
    most = std::max(most, point.on.x);
  }
  EXPECT_NEAR(least, 0.035, 1e-9);
  EXPECT_NEAR(most, 0.05, 1e-9) << "beside the edge nothing is touched";
}

TEST(Polytopes, TouchWithTheirEdgesWhereTheseCross) {
  const Quat onEdge = glm::angleAxis(std::numbers::pi / 4, Vec3(1, 0, 0));
  const Quat across = glm::angleAxis(std::numbers::pi / 2, Vec3(0, 0, 1)) * onEdge;
  const Polytope bar = box({0.1, 0.02, 0.02});
  const double height_m = 0.02 * std::numbers::sqrt2 - 1e-5;
  const Pose upper = at({0.013, -0.008, height_m}, across), lower = at(Vec3(0), onEdge);
  const Quat back = glm::conjugate(lower.rotation);
  const PolytopeContact contact =
      contactOf(bar, bar, {back * upper.rotation, back * upper.position}, {.range_m = 1e-4});
  ASSERT_EQ(contact.count, 1U);
  EXPECT_NEAR(contact.gap_m, -1e-5, 1e-9);
  EXPECT_LT(glm::distance(lower.rotation * contact.points[0].foot, Vec3(0.013, 0, height_m / 2)), 1e-5);
  EXPECT_NEAR((lower.rotation * contact.normal).z, 1, 1e-9);
}

TEST(Polytopes, ThatAreApartTellNoMoreThanTheirDistance) {
  std::mt19937_64 engine(3);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution(low, high)(engine); };
  const Polytope a = box({0.02, 0.015, 0.01}), b = box({0.03, 0.004, 0.02});
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const Quat turn = glm::normalize(Quat(draw(-1, 1), draw(-1, 1), draw(-1, 1), draw(-1, 1)));
    const Pose pose = at({draw(-0.03, 0.03), draw(-0.03, 0.03), draw(-0.03, 0.03)}, turn);
    const PolytopeContact contact = contactOf(a, b, pose, {.range_m = 1});
    if (contact.gap_m <= 0) continue;
    ++apart;
    double nearest_m = 1;
    constexpr int kGrid = 6;  // places of a's box, against b's box in closed form
    for (int n = 0; n < kGrid * kGrid * kGrid; ++n) {
      const Vec3 part = Vec3(n % kGrid, n / kGrid % kGrid, n / kGrid / kGrid) / (kGrid - 1.0) - 0.5;
      const Vec3 place = toWorld(pose, part * Vec3(0.02, 0.015, 0.01));
      const Vec3 beyond = glm::max(glm::abs(place) - Vec3(0.015, 0.002, 0.01), Vec3(0));
      nearest_m = std::min(nearest_m, glm::length(beyond));
    }
    EXPECT_LE(contact.gap_m, nearest_m + 1e-9);
    EXPECT_THAT(contact.all(), Each(Field(&PolytopeContact::Point::gap_m, Gt(0))));
    const Vec3 out = contact.ofSecond ? -contact.normal : contact.normal;
    for (const auto& point : contact.all()) EXPECT_NEAR(glm::dot(out, point.on - point.foot), point.gap_m, 1e-12);
  }
  EXPECT_GT(apart, 500);
}

TEST(Polytopes, PassAFlushNeighboursSideButNotAStep) {
  const auto normalAt = [](double depth_m) {
    const Pose pose =
        at({-0.0601, 0, 0.02 - depth_m});  // reaches the tile's side in 0.1 ms, and lies on the one before it
    return contactOf(box({0.02, 0.02, 0.02}), box({0.1, 0.1, 0.02}), pose,
                     {.range_m = 1e-3, .step_m = 5e-5, .linear = {1, 0, 0}});
  };
  EXPECT_EQ(normalAt(1e-5).count, 0U);
  EXPECT_GT(normalAt(1e-4).count, 0U);
  EXPECT_NEAR(normalAt(1e-4).normal.x, -1, 1e-12);
}

/// A prism lies on the tile before it, its front near the next one's side.
TEST(Polytopes, PassAFlushNeighboursSideHoweverManyFacesTheyHave) {
  constexpr double kRadius_m = 0.02, kReach_m = 0.05, kTop_m = 0.01, kHalf_m = 0.006;
  const std::array tiles{box({2 * kReach_m, 0.1, 2 * kTop_m}),
                         polytopeOf(makeCylinder(kReach_m, 2 * kTop_m, 64).value()).value()};
  for (const std::uint32_t sides : {3U, 6U, 12U, 16U, 24U, 48U, 64U}) {
    const Polytope prism = polytopeOf(makeCylinder(kRadius_m, 2 * kHalf_m, sides).value()).value();
    for (const Polytope& tile : tiles) {
      for (const double before_m : {1e-4, 1e-6, 0.0, -1e-6, -1e-5, -1e-3}) {
        const auto found = [&](double depth_m) {
          const Pose pose = at({-kReach_m - kRadius_m - before_m, 0, kTop_m + kHalf_m - depth_m});
          return contactOf(prism, tile, pose, {.range_m = 4e-4, .step_m = 5e-5, .linear = {0.3, 0, 0}});
        };
        const PolytopeContact flush = found(5e-6);
        EXPECT_TRUE(flush.count == 0 || flush.normal.z > 0.999999) << sides << " sides, " << before_m << " m before";
        EXPECT_TRUE(before_m < 0 || found(3e-4).normal.x < -0.9) << sides << " sides, " << before_m << " m before";
      }
    }
  }
}

TEST(Polytopes, ThatStandExactlyBesideAFlushTileAreNotStoppedByItsSide) {
  const Polytope tile = box({0.04, 0.04, 0.02});
  for (const Polytope& block : {box({0.04, 0.04, 0.02}), polytopeOf(makeCylinder(0.02, 0.02, 64).value()).value()}) {
    for (const double depth_m : {0.0, 4e-6, 3e-5}) {
      for (const Vec3 velocity : {Vec3(0), Vec3(0, 0.3, 0), Vec3(0.3, 0, 0), Vec3(-0.3, 0, 0)}) {
        const PolytopeContact contact =
            contactOf(block, tile, at({-0.04, 0, 0.02 - depth_m}),
                      {.range_m = 1e-4, .step_m = 5e-5, .linear = velocity, .normal = {-1, 0, 0}});
        EXPECT_TRUE(contact.count == 0 || contact.normal.z > 0.999999 || velocity.x < 0)
            << depth_m << ' ' << velocity.x;
      }
      const PolytopeContact deep =
          contactOf(block, tile, at({-0.04, 0, 0.02 - 1e-3}), {.range_m = 1e-4, .step_m = 5e-5});
      EXPECT_LT(deep.normal.x, -0.999);
      EXPECT_GT(deep.count, 0U);
    }
  }
}

TEST(Polytopes, AreNotTurnedOverToAPlatesOtherSide) {
  const Polytope plate = box({0.1, 0.1, 0.001}), brick = box(Vec3(0.02));
  const Pose sunk = at({0, 0, 0.01 - 4e-4});  // 0.9 mm deep in 1 mm
  EXPECT_NEAR(contactOf(brick, plate, sunk, {.range_m = 1e-4, .normal = {0, 0, 1}}).normal.z, 1, 1e-12);
}

}  // namespace
}  // namespace haptics::test::polytope_test
