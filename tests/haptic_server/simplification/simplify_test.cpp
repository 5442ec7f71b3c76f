#include "haptic_server/simplification/simplify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <stop_token>

#include "common/interruption/interruption.h"
#include "common/mesh/generators.h"
#include "haptic_server/simplification/fit.h"
#include "haptic_server/simplification/probe_strokes.h"

namespace haptics::simplify_test {
namespace {

constexpr double kStiffness_N_per_m = 800;

std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

std::optional<SimplifiedMesh> simplified(const TriMesh& mesh, double error_jnd = 1,
                                         double stiffness_N_per_m = kStiffness_N_per_m) {
  return simplify(mesh, *surfaceOf(mesh), error_jnd, stiffness_N_per_m);
}

/// By strokes that it was not judged by.
ForceDifference checked(const TriMesh& mesh, const TriMesh& simple) {
  const auto surface = surfaceOf(mesh);
  const Probes probes = probeStrokes(mesh, *surface, kStiffness_N_per_m, 200, 77);
  return differenceOf(forcesAlong(probes.strokes, *surfaceOf(simple), kStiffness_N_per_m), probes.forces);
}

TEST(Simplify, LeavesOfABoxWhatIsExact) {
  const auto simple = simplified(makeBox(Vec3(0.1), 8).value());
  ASSERT_TRUE(simple);
  EXPECT_EQ(simple->mesh.triangles.size(), 12U);
  EXPECT_NEAR(simple->error_jnd, 0, 1e-3);
}

TEST(Simplify, LeavesFewerTrianglesThatFeelTheSameOnOtherStrokes) {
  for (const TriMesh& mesh : {makeTorus(0.06, 0.02, 128, 64).value(), makeSphere(0.05, 32).value()}) {
    const auto simple = simplified(mesh);
    ASSERT_TRUE(simple);
    EXPECT_LT(simple->mesh.triangles.size(), mesh.triangles.size() * 6 / 10);
    EXPECT_TRUE(surfaceOf(simple->mesh)->closed());
    const ForceDifference difference = checked(mesh, simple->mesh);
    EXPECT_GT(difference.ticks, 10'000);
    EXPECT_LE(difference.felt_ratio, 0.01);
  }
}

TEST(Simplify, LeavesMoreWhereLessMayBeFelt) {
  const TriMesh torus = makeTorus(0.06, 0.02, 128, 64).value();
  const auto left = [&](double error_jnd, double stiffness_N_per_m) {
    const auto simple = simplified(torus, error_jnd, stiffness_N_per_m);
    return simple ? simple->mesh.triangles.size() : torus.triangles.size();
  };
  EXPECT_LT(left(3, kStiffness_N_per_m), left(1, kStiffness_N_per_m));
  EXPECT_LT(left(3, kStiffness_N_per_m), left(3, 4 * kStiffness_N_per_m));
}

TEST(Simplify, LeavesNothingOutWhereEachTriangleIsFelt) {
  EXPECT_FALSE(simplified(makeSphere(0.05, 3).value()));
  EXPECT_FALSE(simplified(makeBox(Vec3(0.1), 1).value()));
}

TEST(Simplify, IsNowhereFartherOffThanTwiceWhatAPressTells) {
  TriMesh lens = makeSphere(0.05, 48).value();
  for (Vec3f& v : lens.vertices) v.z *= 0.1F;
  const auto simple = simplified(lens);
  ASSERT_TRUE(simple);
  EXPECT_LT(simple->mesh.triangles.size(), lens.triangles.size() / 2);
  EXPECT_LE(deviationOf(lens.vertices, *surfaceOf(simple->mesh)), 2 * 0.07 / kStiffness_N_per_m);
}

TEST(Simplify, HasTheSurfaceOfItsMesh) {
  const auto simple = simplified(makeBox(Vec3(0.1), 8).value());
  ASSERT_TRUE(simple);
  ASSERT_EQ(simple->surface->triangleCount(), simple->mesh.triangles.size());
  EXPECT_EQ(deviationOf(simple->mesh.vertices, *simple->surface), 0);
}

TEST(Simplify, OfTheSameMeshIsTheSame) {
  const TriMesh sphere = makeSphere(0.05, 32).value();
  const auto first = simplified(sphere), second = simplified(sphere);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->mesh, second->mesh);
}

TEST(Simplify, HasAPriceThatIsKnownBefore) {
  for (const double radius_m : {1e-6, 1e-4, 1e-3, 0.03, 1.0, 500.0}) {
    const TriMesh sphere = makeSphere(radius_m, 2).value();
    const auto surface = surfaceOf(sphere);
    for (const double stiffness_N_per_m : {1e-300, 0.1, 1.0, 10.0, 100.0, 800.0, 1e5}) {
      const bool isSimplifiable = checkSimplifiable(*surface, stiffness_N_per_m).has_value();
      const double each = placesOfAStroke(2 * radius_m, stiffness_N_per_m);
      EXPECT_EQ(isSimplifiable, 1000 * each <= kMaxPlaces);
      if (!isSimplifiable) continue;
      for (const ProbeStroke& stroke : probeStrokes(sphere, *surface, stiffness_N_per_m, 4, 5).strokes)
        EXPECT_LE(static_cast<double>(stroke.size()), each + 3);
    }
  }
  const auto usual = surfaceOf(makeSphere(0.03, 4).value());
  EXPECT_TRUE(checkSimplifiable(*usual, 40));
  EXPECT_THAT(checkSimplifiable(*usual, 5).error().text(), testing::HasSubstr("1 N presses 0.2 m"));
}

TEST(Simplify, MayBeInterrupted) {
  const TriMesh torus = makeTorus(0.06, 0.02, 64, 32).value();
  const auto surface = surfaceOf(torus);
  std::stop_source stop;
  stop.request_stop();
  const Interruptible work(stop.get_token());
  EXPECT_THROW(static_cast<void>(simplify(torus, *surface, 1, kStiffness_N_per_m)), Interrupted);
}

TEST(ProbeStrokes, AreTheSameOfASeedAndOthersOfAnother) {
  const TriMesh sphere = makeSphere(0.05, 8).value();
  const auto surface = surfaceOf(sphere);
  const auto strokes = probeStrokes(sphere, *surface, kStiffness_N_per_m, 20, 5).strokes;
  EXPECT_EQ(strokes.size(), 20U);
  EXPECT_EQ(strokes, probeStrokes(sphere, *surface, kStiffness_N_per_m, 20, 5).strokes);
  EXPECT_NE(strokes, probeStrokes(sphere, *surface, kStiffness_N_per_m, 20, 6).strokes);
}

TEST(ProbeStrokes, PressWithOneNewtonFromOutside) {
  const TriMesh box = makeBox(Vec3(0.1), 1).value();
  const auto surface = surfaceOf(box);
  double deepest_N = 0;
  for (const Forces& forces : probeStrokes(box, *surface, kStiffness_N_per_m, 20, 5).forces) {
    EXPECT_EQ(forces.front(), Vec3(0));
    for (const Vec3 force : forces) deepest_N = std::max(deepest_N, glm::length(force));
  }
  EXPECT_NEAR(deepest_N, 1, 1e-6);
}

}  // namespace
}  // namespace haptics::simplify_test
