#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic_server/engine/step/soft_bodies.h"
#include "tests/eval/combinations/groove_reference.h"
#include "tests/haptic_server/engine/step/surface_world.h"

// Soft bodies that hold the IHIP together with others.
namespace haptics::dent_solver_tests {
namespace {

using namespace fixture;

struct Wall {
  double lean_rad;            ///< Of its normal, from z towards x.
  double contact_N_per_m;     ///< k.
  double tissue_N_per_m = 0;  ///< t; 0: rigid.

  [[nodiscard]] Vec3 normal() const { return {std::sin(lean_rad), 0, std::cos(lean_rad)}; }
};

/// A block whose upper side is the wall; it begins 5 mm below the line x = z = 0 and rises away from it.
ServoObject blockOf(std::uint64_t id, const Wall& wall) {
  const double away = wall.lean_rad > 0 ? -1 : 1;
  const Vec3 up = away * Vec3(std::cos(wall.lean_rad), 0, -std::sin(wall.lean_rad));
  ServoObject block = objectOf(id, fineBlock(), 0.045 * up - 0.05 * wall.normal(), wall.contact_N_per_m);
  block.pose.rotation = Quat(std::cos(wall.lean_rad / 2), 0, std::sin(wall.lean_rad / 2), 0);
  block.damping_Ns_per_m = 0;
  if (wall.tissue_N_per_m > 0) {
    block.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.03, 2), wall.tissue_N_per_m, 0});
  }
  return block;
}

/// Of two springs in series on each wall.
Vec3 force_N(const Wall& a, const Wall& b, Vec3 hip) {
  const eval::GrooveReference groove({a.normal(), a.contact_N_per_m, a.tissue_N_per_m},
                                     {b.normal(), b.contact_N_per_m, b.tissue_N_per_m});
  return groove.force_N({-glm::dot(a.normal(), hip), -glm::dot(b.normal(), hip)});
}

VirtualServo::Trajectory down(double depth_m, double aside_m = 0) {
  return [=](std::uint64_t tick) {
    return Vec3(aside_m, 0, 0.004 - (0.004 + depth_m) * std::min(1.0, static_cast<double>(tick) / 300));
  };
}

TEST(DentSolver, SpringsOfAllThatHoldTheIhipAreInSeriesWithTheirOwnTissue) {
  const Wall grooves[][2] = {
      {{0.785, 1000, 400}, {-0.785, 1000, 400}}, {{0.785, 1000, 300}, {-0.785, 600, 900}},
      {{0.785, 1000, 300}, {-0.785, 1000}},      {{0.5, 1000, 400}, {-0.7, 1000, 400}},
      {{0.5, 800, 400}, {-0.7, 1000}},           {{1.0, 800, 400}, {-0.9, 1000, 500}},
  };
  for (const auto& [left, right] : grooves) {
    for (const bool swapped : {false, true}) {
      VirtualServo servo(down(0.002), kConfig,
                         swapped ? sceneOf(1, {blockOf(1, right), blockOf(2, left)})
                                 : sceneOf(1, {blockOf(1, left), blockOf(2, right)}));
      const TelemetrySample sample = servo.run(400);
      const Vec3 expected = force_N(left, right, Vec3(0, 0, -0.002));
      EXPECT_LE(glm::distance(sample.force.spring, expected), 0.02 * glm::length(expected))
          << left.lean_rad << " " << right.tissue_N_per_m << " " << swapped << ": " << sample.force.spring.x << " "
          << sample.force.spring.z << " of " << expected.x << " " << expected.z;
      EXPECT_EQ(servo.state().dents.count, (left.tissue_N_per_m > 0 ? 1U : 0U) + (right.tissue_N_per_m > 0 ? 1U : 0U));
    }
  }
}

TEST(DentSolver, HasNoStepFromOneSoftWallToTheOther) {
  const auto across = [](std::uint64_t tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    return Vec3(0.003 * std::sin(6 * t), 0.002 * std::sin(2 * t), 0.004 - 0.006 * std::min(1.0, 4 * t));
  };
  for (const double second_N_per_m : {0.0, 300.0}) {
    VirtualServo servo(across, kConfig,
                       sceneOf(1, {blockOf(1, {0.785, 1000, 400}), blockOf(2, {-0.785, 800, second_N_per_m})}));
    Vec3 before = servo.run(250).force.contact;
    double most_N = 0;
    while (servo.tick() < 3000) {
      const Vec3 now = servo.step().force.contact;
      most_N = std::max(most_N, glm::distance(now, before));
      before = now;
    }
    EXPECT_LE(most_N, 0.05) << second_N_per_m;  // 18 um a tick on 1 N/mm, and as much for what lets go
  }
}

TEST(DentSolver, AndClosedLoopsGiveTheHandNoEnergy) {
  const auto around = [](std::uint64_t tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    const double in = std::min(1.0, 4 * t);
    return Vec3(0.0015 * std::sin(5 * t), 0, 0.004 - 0.006 * in + 0.001 * (1 - std::cos(5 * t)));
  };
  VirtualServo servo(around, kConfig, sceneOf(1, {blockOf(1, {0.785, 1000, 400}), blockOf(2, {-0.6, 800, 300})}));
  const auto loop = static_cast<std::uint64_t>(std::lround(2 * std::numbers::pi / 5 * 1000));
  TelemetrySample last = servo.run(300);
  double work_J = 0;
  Vec3 at = around(299);
  for (std::uint64_t i = 0; i < 4 * loop; ++i) {
    const TelemetrySample now = servo.step();
    const Vec3 hip = around(servo.tick() - 1);
    work_J += glm::dot((now.force.contact + last.force.contact) / 2.0, hip - at);
    at = hip;
    last = now;
  }
  EXPECT_LE(work_J, 4 * 2e-5);
}

/// Soft skin of 3 mm over something hard.
TEST(DentSolver, EndsAtWhatLiesBelowTheSurface) {
  ServoObject skin = objectOf(1, fineBlock(), Vec3(0, 0, -0.05), 1000);
  skin.damping_Ns_per_m = 0;
  skin.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.03, 2), 250, 0});
  static const auto nodule = surfaceOf(makeSphere(0.01, 20).value());
  const ServoObject hard = objectOf(2, nodule, Vec3(0, 0, -0.013), 1000);
  VirtualServo servo(down(0.006), kConfig, sceneOf(1, {skin, hard}));
  double before_N = 0;
  while (servo.tick() < 400) {
    const TelemetrySample sample = servo.step();
    EXPECT_GE(sample.ihip.z, -0.003 - 2e-5) << servo.tick();
    EXPECT_LE(std::abs(sample.force.contact.z - before_N), 0.05) << servo.tick();
    before_N = sample.force.contact.z;
  }
  EXPECT_NEAR(before_N, 1000 * 0.003, 0.03);

  VirtualServo beside(down(0.006, 0.025), kConfig, sceneOf(1, {skin, hard}));
  EXPECT_NEAR(beside.run(400).force.contact.z, 0.006 / (1 / 1000.0 + 1 / 250.0), 0.05);
}

TEST(DentSolver, WhatAnEditTakesFromBelowTheSurfaceIsMissedWithoutAKick) {
  ServoObject skin = objectOf(1, fineBlock(), Vec3(0, 0, -0.05), 1000);
  skin.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.03, 2), 250, 0});
  ServoObject hard = objectOf(2, surfaceOf(makeSphere(0.01, 20).value()), Vec3(0, 0, -0.013), 1000);
  VirtualServo servo(down(0.006), kConfig, sceneOf(1, {skin, hard}));
  Vec3 before_N = servo.run(400).force.written;
  hard.pose.position.z -= 0.04;
  hard.poseRevision = 2;
  servo.adopt(sceneOf(2, {skin, hard}));
  for (int i = 0; i < 400; ++i) {
    const Vec3 now_N = servo.step().force.written;
    EXPECT_LE(glm::distance(now_N, before_N), RateLimitedStiffness::kRate_N_per_s * kConfig.period_s + 1e-9) << i;
    before_N = now_N;
  }
  EXPECT_NEAR(before_N.z, 0.006 / (1 / 1000.0 + 1 / 250.0), 0.05);
}

}  // namespace
}  // namespace haptics::dent_solver_tests
