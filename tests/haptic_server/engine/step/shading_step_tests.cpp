// Force shading (paper 4.1) in the production step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic_server/recording/state_image.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::shading_step_tests {
namespace {

using namespace fixture;

TEST(ShadingInTheStep, MakesACoarseSphereRound) {
  const ServoObject sphere = objectOf(1, surfaceOf(makeSphere(0.05, 12).value()), Vec3(0));
  VirtualServo servo(overSphere, kConfig, sceneOf(1, {with(sphere, shading(std::numbers::pi))}));
  servo.run(500);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    const Vec3 out = glm::normalize(s.hip);
    EXPECT_LE(glm::length(s.surfaceNormal - out), 1e-5);
    EXPECT_NEAR(s.penetration_m, 0.002, 2e-6);
    EXPECT_LE(glm::distance(s.ihip, 0.05 * out), 2e-6);
  }
}

TEST(ShadingInTheStep, ThatOnlyDeepensGoesOnFromAnImageBitForBit) {
  ServoObject sphere = with(objectOf(1, surfaceOf(makeSphere(0.05, 12).value()), Vec3(0)), shading(std::numbers::pi));
  auto level = std::make_shared<SurfaceDetail>(*sphere.detail);
  level->reach_m = 0;  // as of an open bowl
  sphere.detail = level;
  const std::shared_ptr<const ServoScene> scene = sceneOf(1, {sphere});
  VirtualServo servo(overSphere, kConfig, scene);
  servo.run(700);
  auto state = stateFrom(stateImage(servo.state()), *scene, kConfig).value();
  for (std::uint64_t tick = 700; tick < 750; ++tick) {
    const DeviceReading reading{overSphere(tick), DeviceState::kReady, {}};
    const Vec3 again = hapticStep(*scene, *state, kConfig, {tick, 0, reading}).force.written;
    ASSERT_EQ(again, servo.step().force.written) << tick;
  }
}

TEST(ShadingInTheStep, EndsWithoutAStepWhereAWallStopsTheIhipBetweenTheLinesOfACoarseSphere) {
  const auto path = [](std::uint64_t tick) {
    const double down = std::min(1.0, static_cast<double>(tick) / 200);
    const double x = 0.004 - (tick > 300 ? 3e-5 * static_cast<double>(tick - 300) : 0);
    return (0.052 - 0.004 * down) * glm::normalize(Vec3(x, 0.003, 0.05));
  };
  VirtualServo servo(path, kConfig);
  const ServoObject sphere = objectOf(1, surfaceOf(makeSphere(0.05, 6).value()), Vec3(0));
  servo.adopt(sceneOf(1, {with(sphere, shading(std::numbers::pi)), slab(2, Vec3(-0.05 - 0.003, 0, 0.06))}));
  TelemetrySample last = servo.run(320);
  bool met = false;
  for (int i = 0; i < 400 && !met; ++i) {
    const TelemetrySample now = servo.step();
    met = now.ihip.x > now.hip.x + 1e-9 && now.ihip.x > -0.0031 && now.hip.x < -0.0029;
    EXPECT_LE(glm::length(now.force.contact - now.force.damping - (last.force.contact - last.force.damping)), 0.035)
        << i;
    last = now;
  }
  EXPECT_GT(glm::length(glm::cross(last.force.spring, glm::normalize(last.ihip))), 0) << "unshaded now";
}

TEST(ShadingInTheStep, KeepsTheRimOfACylinderSharp) {
  SurfaceProperties properties = shading(std::numbers::pi / 3);
  const ServoObject cylinder = with(objectOf(1, surfaceOf(makeCylinder(0.02, 0.08, 48).value()), Vec3(0)), properties);
  const auto pressOn = [&](Vec3 place, Vec3 inward) {
    VirtualServo servo(
        [=](std::uint64_t tick) { return place + inward * std::min(0.0004, 2e-5 * static_cast<double>(tick) - 0.002); },
        kConfig, sceneOf(1, {cylinder}));
    const TelemetrySample s = servo.run(400);
    return glm::normalize(s.force.contact);
  };
  const double degree = std::numbers::pi / 180;
  for (double angle = 0.02; angle < 6.28; angle += 0.1) {
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    EXPECT_LE(glm::distance(pressOn(out * 0.0195 + Vec3(0, 0, 0.04), Vec3(0, 0, -1)), Vec3(0, 0, 1)), degree) << angle;
    EXPECT_LE(glm::distance(pressOn(out * 0.02 + Vec3(0, 0, 0.0395), -out), out), 0.1 * degree) << angle;
  }
}

TEST(ShadingInTheStep, GoesOverToAnInnerEdgeAndOutWithoutAStep) {
  // Two slabs that overlap make an inner edge at x = 0, z = 0; one is shaded, with the normals of all its edges meeting.
  const auto path = [](std::uint64_t tick) {
    return Vec3(0.03 - 3e-5 * static_cast<double>(tick), 0.0123,
                0.003 - std::min(0.005, 2.5e-5 * static_cast<double>(tick)));
  };
  const auto largestStep = [&](bool shaded) {
    VirtualServo servo(path, kConfig);
    const ServoObject floor = slab();
    servo.adopt(sceneOf(1, {shaded ? with(floor, shading(std::numbers::pi)) : floor, slab(2, Vec3(-0.05, 0, 0.02))}));
    double most = 0;
    Vec3 last(0);
    for (int i = 0; i < 1400; ++i) {
      const TelemetrySample s = servo.step();
      if (i > 250) most = std::max(most, glm::length(s.force.contact - s.force.damping - last));
      last = s.force.contact - s.force.damping;
    }
    return most;
  };
  EXPECT_LE(largestStep(true), largestStep(false) + 0.03);
}

}  // namespace
}  // namespace haptics::shading_step_tests
