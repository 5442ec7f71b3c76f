#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/engine/step/soft_bodies.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::soft_bodies_tests {
namespace {

using namespace fixture;

constexpr double kRadius_m = 0.05;
constexpr double kContact_N_per_m = 1000;
constexpr double kPeriod_s = 1e-3;
constexpr StepConfig kConfig{.period_s = kPeriod_s, .maxForce_N = 1e9};

const TriMesh& fineSphere() {
  static const TriMesh mesh = makeSphere(kRadius_m, 73).value();  // 63,948 triangles
  return mesh;
}

std::shared_ptr<const ServoScene> softSphere(const SoftTissue& tissue, const TriMesh& mesh = fineSphere()) {
  static std::map<const TriMesh*, std::shared_ptr<const CollisionMesh>> surfaces;
  auto& surface = surfaces[&mesh];
  if (!surface) surface = surfaceOf(mesh);
  auto object = fixture::objectOf(1, surface, Vec3(0), kContact_N_per_m);
  object.damping_Ns_per_m = 0;
  object.tissue = std::make_shared<const SoftTissue>(tissue);
  return sceneOf(1, {object});
}

SoftTissue elastic(double stiffness_N_per_m, double radius_m = 0.015) {
  return {Falloff(radius_m, 2), stiffness_N_per_m, 0};
}

TEST(SoftBody, IsFeltAsItsTwoSpringsInSeries) {
  const double depth = 0.003;
  VirtualServo servo(
      [&](std::uint64_t tick) { return Vec3(0, 0, kRadius_m + 0.01 - 0.013 * std::min(1.0, double(tick) / 200)); },
      kConfig, softSphere(elastic(250)));
  const TelemetrySample sample = servo.run(300);
  EXPECT_EQ(sample.object, 1U);
  const double expected = depth / (1 / kContact_N_per_m + 1 / 250.0);
  EXPECT_NEAR(sample.force.spring.z, expected, 0.02 * expected);
  EXPECT_NEAR(sample.penetration_m, expected / kContact_N_per_m, 2e-5);
}

TEST(SoftBody, TurnsHardBeforeItTurnsInsideOut) {
  VirtualServo servo([&](std::uint64_t tick) { return Vec3(0, 0, kRadius_m + 0.001 - 2e-5 * double(tick)); }, kConfig);
  const SoftTissue tissue = elastic(10, 0.008);
  servo.adopt(softSphere(tissue));
  const TelemetrySample deep = servo.run(550);
  ASSERT_EQ(servo.state().dents.count, 1U);
  const Dent& dent = servo.state().dents[0].dent;
  EXPECT_NEAR(glm::length(Vec3(dent.displacement)), maxDentDepth_m(tissue.falloff), 1e-6);
  EXPECT_GT(deep.force.spring.z, kContact_N_per_m * (0.01 - 1e-4 - maxDentDepth_m(tissue.falloff)));
  for (const TriangleIndices& t : fineSphere().triangles) {
    std::array<Vec3, 3> rest, now;
    for (std::size_t k = 0; k < 3; ++k) {
      rest[k] = Vec3(fineSphere().vertices[t[k]]);
      now[k] = Vec3(dented(fineSphere().vertices[t[k]], {&dent, 1}, tissue.falloff));
    }
    ASSERT_GT(glm::dot(glm::cross(rest[1] - rest[0], rest[2] - rest[0]), glm::cross(now[1] - now[0], now[2] - now[0])),
              0);
  }
}

/// The hand draws back faster than the surface is pressed below it: found with the surface as the last tick left it, the
/// contact would be lost.
TEST(SoftBody, KeepsTheContactWhileTheSurfaceMovesMoreInATickThanTheHipIsBelowIt) {
  const auto height = [](std::uint64_t tick) { return kRadius_m - 0.003 * std::sin(0.2 * double(tick)); };
  VirtualServo servo([&](std::uint64_t tick) { return Vec3(0, 0, height(tick)); }, kConfig, softSphere(elastic(20)));
  int falseExits = 0, touching = 0, fast = 0;
  double lastSurface = kRadius_m, lastDepth = 0;
  for (std::uint64_t tick = 0; tick < 2000; ++tick) {
    const TelemetrySample sample = servo.step();
    const bool inside = height(tick) < kRadius_m - 2e-5;  // the sphere's facets lie below the sphere
    falseExits += inside && sample.object == 0;
    touching += sample.object != 0;
    const double surface = sample.object != 0 ? sample.ihip.z : kRadius_m;
    fast += sample.object != 0 && std::abs(surface - lastSurface) > std::max(lastDepth, sample.penetration_m);
    lastSurface = surface;
    lastDepth = sample.penetration_m;
  }
  EXPECT_EQ(falseExits, 0);
  EXPECT_GT(touching, 900);
  EXPECT_GT(fast, 500) << "the scene does not do what it is for";
}

constexpr double kBlock_m = 0.01, kBlockBelow_m = 0.003;

/// A soft body, slow to go back, with a block in it.
std::shared_ptr<const ServoScene> withBlock() {
  auto scene = std::make_shared<ServoScene>(*softSphere({Falloff(0.02, 2), 10, 0.2}));
  const auto block = surfaceOf(makeBox(Vec3(kBlock_m), 2).value());
  scene->objects.push_back(
      fixture::objectOf(2, block, {0, 0, kRadius_m - kBlockBelow_m - kBlock_m / 2}, kContact_N_per_m));
  return scene;
}

TEST(SoftBody, EndsItsDentAtWhatIsBelow) {
  const auto depth = [](std::uint64_t tick) {
    return tick < 2000 ? std::min(2e-5 * double(tick) - 0.002, 0.006) : 0.004;
  };
  VirtualServo servo([&](std::uint64_t tick) { return Vec3(0.0002, 0.0003, kRadius_m - depth(tick)); }, kConfig,
                     withBlock());
  for (const double below_m : {0.003, 0.001}) {
    const TelemetrySample within = servo.run(servo.tick() == 0 ? 2000 : 1);
    EXPECT_EQ(within.object, 1U);
    EXPECT_NEAR(within.ihip.z, kRadius_m - kBlockBelow_m, 1e-5);
    EXPECT_NEAR(within.force.spring.z, below_m * kContact_N_per_m, 0.02);
  }
}

/// A hand that comes back to a dent which is still there is clear of it, but not of a block within the soft body.
TEST(SoftBody, LetsWhatReachesIntoItsDentBeMetThere) {
  const auto at = [](std::uint64_t tick) {
    if (tick < 1500) return Vec3(-0.0055, 0.0003, kRadius_m - std::min(2e-5 * double(tick) - 0.002, 0.008));
    if (tick < 1505) return Vec3(-0.0055, 0.0003, kRadius_m + 0.03);
    return Vec3(0.0002, 0.0003, kRadius_m - 0.004);
  };
  VirtualServo servo(at, kConfig, withBlock());
  EXPECT_EQ(servo.run(1500).object, 1U);
  EXPECT_EQ(servo.run(5).object, 0U);
  const TelemetrySample within = servo.run(1);
  EXPECT_EQ(within.object, 2U);
  EXPECT_NEAR(within.ihip.z, kRadius_m - kBlockBelow_m, 1e-6);
  EXPECT_NEAR(within.force.spring.z, 0.001 * kContact_N_per_m, 1e-3);
}

/// Of the whole dented mesh.
double nearest_m(const TriMesh& mesh, std::span<const Dent> dents, const Falloff& falloff, Vec3 from) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    TriangleRecord r{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f v = dented(mesh.vertices[mesh.triangles[t][k]], dents, falloff);
      for (std::size_t d = 0; d < 3; ++d) r.rows[d][k] = v[static_cast<int>(d)];
    }
    nearest = std::min(nearest, closestOn(r, t, from).squaredDistance);
  }
  return std::sqrt(nearest);
}

TEST(SoftBody, HasItsIhipWhereTheDentedMeshIsNearest) {
  for (const double returnTime_s : {0.0, 0.3}) {
    const SoftTissue tissue{Falloff(0.012, 2), 300, returnTime_s};
    const auto hip = [](std::uint64_t tick) {
      const double t = double(tick) * kPeriod_s;
      const double angle = 0.4 * std::sin(3 * t);
      const double r = kRadius_m + 0.002 - 0.005 * std::abs(std::sin(5 * t));
      return r * Vec3(std::sin(angle), 0.3 * std::sin(angle), std::cos(angle));
    };
    VirtualServo servo(hip, kConfig, softSphere(tissue));
    double worst = 0;
    for (std::uint64_t tick = 0; tick < 2000; ++tick) {
      const TelemetrySample sample = servo.step();
      if (sample.object == 0 || tick % 40 != 0) continue;
      std::vector<Dent> dents;
      for (const BodyDent& dent : servo.state().allDents()) dents.push_back(dent.dent);
      const double distance = nearest_m(fineSphere(), dents, tissue.falloff, hip(tick));
      worst = std::max(worst, sample.penetration_m - distance);
      EXPECT_LT(nearest_m(fineSphere(), dents, tissue.falloff, sample.ihip), 1e-9) << "the IHIP is on the mesh";
    }
    EXPECT_LT(worst, 1e-4);
  }
}

TEST(SoftBody, ThatIsViscousLeavesADentThatComesBackToAStillHandWithoutAStep) {
  const SoftTissue tissue{Falloff(0.015, 2), 300, 0.1};
  const auto hip = [](std::uint64_t tick) {
    if (tick < 500) return Vec3(0, 0, kRadius_m - 0.003 * std::min(1.0, double(tick) / 300));
    return Vec3(0, 0, kRadius_m - 0.001);  // 2 mm back at once: out of the dent
  };
  VirtualServo servo(hip, kConfig, softSphere(tissue));
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(servo.step().object != 0 || i < 5);
  TelemetrySample sample = servo.step();
  EXPECT_EQ(sample.object, 0U);
  EXPECT_EQ(glm::length(sample.force.written), 0);
  EXPECT_EQ(servo.state().dents.count, 1U);
  bool touched = false;
  double last = 0, steepest = 0;
  for (int i = 0; i < 2000; ++i) {
    sample = servo.step();
    EXPECT_FALSE(touched && sample.object == 0) << "tick " << i;
    touched = touched || sample.object != 0;
    steepest = std::max(steepest, std::abs(sample.force.written.z - last));
    last = sample.force.written.z;
  }
  EXPECT_TRUE(touched);
  EXPECT_LT(steepest, 0.02);
  EXPECT_NEAR(last, 0.001 / (1 / kContact_N_per_m + 1 / 300.0), 0.01);
}

TEST(SoftBody, IsAsItWasOnceEveryDentHasGoneBack) {
  const SoftTissue tissue{Falloff(0.015, 2), 300, 0.05};
  const auto hip = [](std::uint64_t tick) {
    const double along = tick < 3000 ? 0.04 * std::sin(0.001 * double(tick)) : 0.5;
    return Vec3(along, 0, kRadius_m - 0.002 + 0.003 * std::sin(0.05 * double(tick)));
  };
  VirtualServo servo(hip, kConfig, softSphere(tissue));
  std::size_t most = 0;
  for (int i = 0; i < 3000; ++i) {
    static_cast<void>(servo.step());
    most = std::max(most, servo.state().dents.count);
  }
  EXPECT_GT(most, 1U);
  static_cast<void>(servo.run(2000));
  EXPECT_EQ(servo.state().dents.count, 0U);
}

/// The most that a hand on a given path has got out of a scene so far, at any time, and what it has at the end; joules.
struct Work {
  double most_J = 0, end_J = 0;
};

Work workOnASlidingHand(const std::shared_ptr<const ServoScene>& scene) {
  const auto hip = [](std::uint64_t tick) {
    const double angle = 2e-3 * double(tick);
    return (kRadius_m + 0.002 - 0.005 * std::abs(std::sin(0.01 * double(tick)))) *
           Vec3(std::sin(angle), 0.1, std::cos(angle)) / std::sqrt(1.01);
  };
  VirtualServo servo(hip, kConfig, scene);
  Work work;
  Vec3 lastHip = hip(0), lastForce(0);
  for (std::uint64_t tick = 0; tick < 3142; ++tick) {
    const TelemetrySample sample = servo.step();
    // By the mean of the two ticks: held forces would add the sampling's own energy.
    work.end_J += glm::dot(0.5 * (lastForce + sample.force.contact), hip(tick) - lastHip);
    work.most_J = std::max(work.most_J, work.end_J);
    lastHip = hip(tick);
    lastForce = sample.force.contact;
  }
  return work;
}

TEST(SoftBody, GivesTheHandNoEnergy) {
  auto hard = std::make_unique<ServoScene>(*softSphere(elastic(300)));
  hard->objects[0].tissue = nullptr;
  hard->objects[0].stiffness_N_per_m = 1 / (1 / kContact_N_per_m + 1 / 300.0);
  const Work rigid = workOnASlidingHand(std::move(hard));  // as stiff: its facets and the sampling's error
  const Work soft = workOnASlidingHand(softSphere(elastic(300)));
  const Work viscous = workOnASlidingHand(softSphere({Falloff(0.015, 2), 300, 0.05}));
  // Ten presses, each of which stores 1 mJ; the dent's own facets turn the force by a little.
  EXPECT_LT(soft.most_J, rigid.most_J + 5e-3 * 10e-3);
  EXPECT_LT(viscous.most_J, rigid.most_J + 1e-6);
  EXPECT_LT(viscous.end_J, -1e-3) << "it is a damper";
}

TEST(SoftBody, EditedUnderTheStylusGoesOnWithoutAKick) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0, kRadius_m - 0.002); }, kConfig);
  const auto before = softSphere(elastic(300));
  auto after = std::make_unique<ServoScene>(*before);
  after->revision = 2;
  after->objects[0].tissue = std::make_shared<const SoftTissue>(elastic(100));
  auto rigid = std::make_unique<ServoScene>(*before);
  rigid->revision = 3;
  rigid->objects[0].tissue = nullptr;
  // Down first: a hand does not begin inside.
  VirtualServo hand(
      [](std::uint64_t tick) { return Vec3(0, 0, kRadius_m + 0.001 - 0.003 * std::min(1.0, double(tick) / 100)); },
      kConfig, before);
  double last = hand.run(300).force.written.z;
  ASSERT_GT(last, 0.3);
  const auto steepestOver = [&](std::shared_ptr<const ServoScene> scene) {
    hand.adopt(std::move(scene));
    double steepest = 0;
    for (int i = 0; i < 400; ++i) {
      const double now = hand.step().force.written.z;
      steepest = std::max(steepest, std::abs(now - last));
      last = now;
    }
    return steepest;
  };
  EXPECT_LT(steepestOver(std::move(after)), 0.05);
  EXPECT_LT(steepestOver(std::move(rigid)), 0.1);
  EXPECT_NEAR(last, 2, 0.1);
}

TEST(SoftBody, GoesOnTheSameFromACopyOfTheState) {
  const auto scene = softSphere({Falloff(0.01, 3), 200, 0.2});
  VirtualServo servo(
      [](std::uint64_t tick) {
        return Vec3(1e-5 * double(tick), 0, kRadius_m - 0.002 * std::sin(0.02 * double(tick)));
      },
      kConfig, scene);
  static_cast<void>(servo.run(700));
  HapticState copy(kConfig);
  copy.copyInUse(servo.state());
  for (std::uint64_t i = 700; i < 900; ++i) {
    const Vec3 hip(1e-5 * double(i), 0, kRadius_m - 0.002 * std::sin(0.02 * double(i)));
    const TelemetrySample one = servo.step();
    const TelemetrySample other = hapticStep(*scene, copy, kConfig, {i, 0, {hip, DeviceState::kReady}});
    ASSERT_EQ(one.ihip, other.ihip);
    ASSERT_EQ(one.force.written, other.force.written);
  }
}

}  // namespace
}  // namespace haptics::soft_bodies_tests
