#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/scene/deformation_properties.h"
#include "tests/haptic_server/engine/step/surface_world.h"

// Surface properties on bodies that give: they are those of the material, wherever that is now.
namespace haptics::soft_surface_tests {
namespace {

using namespace fixture;

constexpr double kPad_N_per_m = 1000;
constexpr double kSide_m = 0.1;
constexpr std::uint32_t kEdges = 50;  // of 2 mm
constexpr double kTop_m = kSide_m / 2;

std::shared_ptr<const CollisionMesh> padSurface() {
  static const auto surface = surfaceOf(makeBox(Vec3(kSide_m), kEdges).value());
  return surface;
}

/// The upper side is the plane z = 0 at rest.
ServoObject pad(const SurfaceProperties& properties, const DetailFields& fields = {}) {
  ServoObject object = objectOf(1, padSurface(), Vec3(0, 0, -kTop_m), kPad_N_per_m);
  object.damping_Ns_per_m = 0;
  object.detail = makeSurfaceDetail(*object.surface, properties, fields);
  return object;
}

ServoObject soft(ServoObject object, double stiffness_N_per_m = 400) {
  object.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.02, 2), stiffness_N_per_m, 0});
  return object;
}

/// Presses to a depth that goes up and down while the hand moves over the pad.
Vec3 rub(std::uint64_t tick) {
  const double t = 1e-3 * static_cast<double>(tick);
  const double depth_m = 0.003 + 0.002 * std::sin(5 * t);
  return {-0.02 + 0.02 * t, 0.0113 + 0.004 * std::sin(3 * t), 0.002 - (0.002 + depth_m) * std::min(1.0, 5 * t)};
}

TEST(SoftSurface, HasTheHeightOfTheMaterialHoweverFarItGivesWay) {
  SurfaceProperties properties;
  properties.texture = acrossDepth();
  const ServoObject textured = pad(properties, {depthField(), nullptr, nullptr});
  for (const bool isSoft : {false, true}) {
    VirtualServo servo(rub, kConfig, sceneOf(1, {isSoft ? soft(textured) : textured}));
    double least_m = 1, most_m = 0;
    while (servo.tick() < 2000) {
      const TelemetrySample sample = servo.step();
      if (servo.tick() < 200) continue;
      ASSERT_EQ(sample.object, 1U) << servo.tick();
      least_m = std::min(least_m, sample.height_m);
      most_m = std::max(most_m, sample.height_m);
    }
    EXPECT_NEAR(least_m, kHeight_m, 0.01 * kHeight_m) << isSoft;
    EXPECT_NEAR(most_m, kHeight_m, 0.01 * kHeight_m) << isSoft;
  }
}

TEST(SoftSurface, HasTheHeightOfTheMaterialUnderALattice) {
  // Tilted by 4 mm from one side to the other.
  Lattice lattice{.low_m = Vec3(-0.06), .size_m = Vec3(0.12), .points = {2, 2, 2}, .control_m = {}};
  for (const double z : {-0.06, 0.06}) {
    for (const double y : {-0.06, 0.06}) {
      for (const double x : {-0.06, 0.06}) lattice.control_m.emplace_back(x, y, z + (x > 0 ? 0.004 : 0));
    }
  }
  const TriMesh mesh = makeBox(Vec3(kSide_m), kEdges).value();
  const auto shaped = shapedBy(lattice, mesh.vertices);
  SurfaceProperties properties;
  properties.texture = acrossDepth();
  ServoObject tilted = pad({});
  tilted.surface = surfaceOf({shaped, mesh.triangles});
  tilted.detail =
      makeSurfaceDetail(*tilted.surface, properties,
                        {depthField(), nullptr, nullptr, std::make_shared<const std::vector<Vec3f>>(mesh.vertices)});
  for (const bool isSoft : {false, true}) {
    VirtualServo servo(rub, kConfig, sceneOf(1, {isSoft ? soft(tilted) : tilted}));
    while (servo.tick() < 2000) {
      const TelemetrySample sample = servo.step();
      if (servo.tick() < 300) continue;
      ASSERT_EQ(sample.object, 1U) << servo.tick();
      ASSERT_NEAR(sample.height_m, kHeight_m, 0.01 * kHeight_m) << isSoft << " " << servo.tick();
    }
  }
}

/// Half of what the lateral force spans, N, while the hand, 6.6 mm deep, draws a line at a slant to the mesh.
double rippleOf(const ServoObject& object) {
  const auto stroke = [](std::uint64_t tick) {
    const double down = std::min(1.0, static_cast<double>(tick) / 300);
    const double along = tick > 500 ? 0.13e-3 * static_cast<double>(tick - 500) : 0;
    return Vec3(-0.025 + along, 0.0113 + 0.1 * along, 0.001 - 0.0076 * down);
  };
  VirtualServo servo(stroke, kConfig, sceneOf(1, {object}));
  double least_N = std::numeric_limits<double>::max(), most_N = -least_N;
  while (servo.tick() < 850) {
    const TelemetrySample sample = servo.step();
    if (servo.tick() < 510) continue;
    EXPECT_EQ(sample.object, 1U);
    EXPECT_NEAR(sample.force.contact.z, 1.9, 0.1);
    least_N = std::min({least_N, sample.force.contact.x, sample.force.contact.y});
    most_N = std::max({most_N, sample.force.contact.x, sample.force.contact.y});
  }
  return (most_N - least_N) / 2;
}

TEST(SoftSurface, ThatIsSmoothIsRubbedWithoutItsMesh) {
  EXPECT_LE(rippleOf(soft(pad(shading(0.5)))), 0.01);
  EXPECT_GT(rippleOf(soft(pad({}))), 0.05) << "with its facets, which the normals take away";
}

TEST(SoftSurface, IsShadedBySphereAndDentTogether) {
  const TriMesh mesh = makeSphere(0.05, 12).value();
  ASSERT_NEAR(static_cast<double>(mesh.triangles.size()), 1700, 100);
  ServoObject ball = objectOf(1, surfaceOf(mesh), Vec3(0), kPad_N_per_m);
  ball.damping_Ns_per_m = 0;
  ball.detail = makeSurfaceDetail(*ball.surface, shading(1), {});
  VirtualServo servo(aboutSphere, kConfig, sceneOf(1, {soft(ball)}));
  double squares = 0;
  int count = 0;
  while (servo.tick() < 2000) {
    const TelemetrySample sample = servo.step();
    if (servo.tick() < 400) continue;
    ASSERT_EQ(sample.object, 1U);
    // The dent is symmetrical about the way to the middle of the sphere.
    const double cosine = glm::dot(glm::normalize(sample.force.contact), glm::normalize(aboutSphere(servo.tick() - 1)));
    squares += std::pow(std::acos(std::min(1.0, cosine)), 2);
    ++count;
  }
  EXPECT_LE(std::sqrt(squares / count) * 180 / std::numbers::pi, 0.25);
}

/// The smooth surface lies above its polygons, in the hollow of a dent too.
TEST(SoftSurface, ThatIsSmoothComesBackToAStillHandWithoutAStep) {
  const TriMesh mesh = makeSphere(0.05, 4).value();
  const auto& [a, b, c] = mesh.triangles[0];
  const Vec3 middle = (Vec3(mesh.vertices[a]) + Vec3(mesh.vertices[b]) + Vec3(mesh.vertices[c])) / 3.0;
  const Vec3 outwards = glm::normalize(middle);
  ServoObject ball = objectOf(1, surfaceOf(mesh), Vec3(0), kPad_N_per_m);
  ball.damping_Ns_per_m = 0;
  ball.detail = makeSurfaceDetail(*ball.surface, shading(1), {});
  ball.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.02, 2), 400, 0.1});
  const auto hip = [&](std::uint64_t tick) {
    const double depth_m = tick < 500 ? 0.004 * std::min(1.0, static_cast<double>(tick) / 300) : 0.001;
    return middle - depth_m * outwards;
  };
  VirtualServo servo(hip, kConfig, sceneOf(1, {ball}));
  while (servo.tick() < 600) (void)servo.step();
  ASSERT_EQ(servo.state().dents.count, 1U);
  Vec3 last_N = servo.step().force.contact;
  double steepest_N = 0;
  while (servo.tick() < 3000) {
    const Vec3 now_N = servo.step().force.contact;
    steepest_N = std::max(steepest_N, glm::distance(now_N, last_N));
    last_N = now_N;
  }
  EXPECT_LT(steepest_N, 0.03);
  EXPECT_GT(glm::length(last_N), 0.3);
}

}  // namespace
}  // namespace haptics::soft_surface_tests
