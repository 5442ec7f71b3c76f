// Section 4 of the paper in the production step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic_server/servo/allocation_tripwire.h"
#include "surface_world.h"

namespace haptics {
namespace {

using testing::friction;
using testing::objectOf;
using testing::sceneOf;
using testing::shading;
using testing::slab;
using testing::surfaceOf;
using testing::VirtualServo;
using testing::with;
using testing::withGrating;

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 1e9};
constexpr double kStiffness = 800;  // of testing::slab()

/// Down to `depth_m` on the slab at x = -40 mm within 200 ticks, then along x.
VirtualServo::Trajectory strokeAlongX(double depth_m, double speed_m_per_s) {
  return [=](std::uint64_t tick) {
    const double down = std::min(1.0, static_cast<double>(tick) / 200);
    const double along = tick > 300 ? 1e-3 * speed_m_per_s * static_cast<double>(tick - 300) : 0;
    return Vec3(-0.04 + along, 0.0123, 0.003 - (0.003 + depth_m) * down);
  };
}

TEST(SurfaceProperties, ChangeNothingWhereAnotherObjectHasThem) {
  const auto run = [](bool detailed) {
    VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig);
    ServoObject other = slab(2, Vec3(0, 0, -0.5));
    servo.adopt(sceneOf(1, {slab(), detailed ? with(other, friction(0.5, 0.4)) : other}));
    double sum = 0;
    for (int i = 0; i < 1500; ++i) {
      const Vec3 f = servo.step().force.written;
      sum += f.x + 3 * f.y + 7 * f.z;
    }
    return sum;
  };
  EXPECT_EQ(run(false), run(true));
}

TEST(SurfaceProperties, FrictionBreaksAwayAtTheStaticAndSlidesAtTheDynamicCoefficient) {
  VirtualServo servo(strokeAlongX(0.002, 0.005), kConfig);
  servo.adopt(sceneOf(1, {with(slab(), friction(0.6, 0.3))}));
  double most = 0;
  TelemetrySample sample;
  for (int i = 0; i < 3000; ++i) {
    sample = servo.step();
    if (sample.frictionState == FrictionState::kSticking) most = std::max(most, glm::length(sample.force.friction));
  }
  const double normal_N = sample.force.spring.z + sample.force.damping.z;
  EXPECT_EQ(sample.frictionState, FrictionState::kSliding);
  EXPECT_NEAR(most / (kStiffness * 0.002), 0.6, 0.006);
  EXPECT_NEAR(-sample.force.friction.x / normal_N, 0.3, 0.0015);
  EXPECT_NEAR(sample.force.friction.z, 0, 1e-9);
  EXPECT_LT(sample.stickingPoint.x, sample.ihip.x);
  EXPECT_NEAR(sample.stickingPoint.z, 0, 1e-9);
  EXPECT_LT(sample.frictionEnergy_J, 0);
}

TEST(SurfaceProperties, FrictionFollowsAFieldOverTheSurface) {
  SurfaceProperties properties = friction(0.6, 0.3);
  properties.friction->variation = 0.5;
  properties.friction->over = FieldFamily{FourierFamily{}};
  VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig);
  servo.adopt(sceneOf(1, {with(slab(), properties, {nullptr, testing::gratingField(0.01), nullptr})}));
  servo.run(500);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    const double factor = 1 + 0.5 * std::cos(2 * std::numbers::pi * s.ihip.x / 0.01);
    const double normal_N = s.force.spring.z + s.force.damping.z;
    EXPECT_NEAR(-s.force.friction.x / normal_N, 0.3 * factor, 0.0015) << s.ihip.x;
  }
}

TEST(SurfaceProperties, FrictionFollowsAScaleGivenByVertex) {
  const ServoObject box = slab();
  const TriMesh mesh = makeBox(Vec3(0.1), 8).value();
  auto scale = std::make_shared<std::vector<float>>();
  for (const Vec3f v : mesh.vertices) scale->push_back(1 + 10 * v.x);  // from 0.5 to 1.5
  VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig);
  servo.adopt(sceneOf(1, {with(box, friction(0.6, 0.3), {nullptr, nullptr, scale})}));
  servo.run(500);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    const double normal_N = s.force.spring.z + s.force.damping.z;
    EXPECT_NEAR(-s.force.friction.x / normal_N, 0.3 * (1 + 10 * s.ihip.x), 0.0015) << s.ihip.x;
  }
}

TEST(SurfaceProperties, ATexturedFloorIsFeltWithoutAStepInTheCornerWithAPlainWall) {
  const auto path = [](std::uint64_t tick) {  // along the floor to the wall at x = 0, into it, and out again
    const double t = 1e-5 * static_cast<double>(tick);
    return Vec3(0.01 - (t < 0.012 ? t : 0.024 - t), 0.0123,
                tick < 100 ? 0.001 : 0.001 - std::min(0.002, 2e-5 * static_cast<double>(tick - 100)));
  };
  const auto largestStep = [&](bool textured) {
    VirtualServo servo(path, kConfig);
    const ServoObject floor = slab();
    servo.adopt(sceneOf(1, {textured ? withGrating(floor, 0.008, 0.0002, 1) : floor, slab(2, Vec3(-0.05, 0, 0.02))}));
    double most = 0;
    Vec3 last(0);
    for (int i = 0; i < 2300; ++i) {
      const TelemetrySample s = servo.step();
      const Vec3 now = s.force.contact - s.force.damping;
      if (i > 250) most = std::max(most, glm::length(now - last));
      last = now;
    }
    return most;
  };
  EXPECT_LE(largestStep(true), largestStep(false) + 0.02);
}

TEST(SurfaceProperties, FrictionGoesOnOverTheSeamBetweenTwoObjects) {
  VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig);
  const ServoObject left = with(slab(1, Vec3(-0.06, 0.01, -0.05)), friction(0.6, 0.6));
  const ServoObject right = with(slab(2, Vec3(0.04, -0.01, -0.05)), friction(0.6, 0.6));
  servo.adopt(sceneOf(1, {left, right}));
  servo.run(450);
  bool crossed = false;
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    EXPECT_LE(s.force.friction.x, -0.5 * kStiffness * 0.002) << s.hip.x;
    crossed = crossed || s.object == 2;
  }
  EXPECT_TRUE(crossed);
}

TEST(SurfaceProperties, TheStickingPointMovesWithItsObject) {
  const auto press = [](std::uint64_t tick) {
    return Vec3(tick > 300 ? 0.0005 : 0, 0.0123, std::max(-0.002, 0.003 - 5e-5 * static_cast<double>(tick)));
  };
  VirtualServo servo(press, kConfig);
  servo.adopt(sceneOf(1, {with(slab(), friction(0.9, 0.8))}));
  const TelemetrySample before = servo.run(400);
  ServoObject moved = with(slab(1, Vec3(0.0005, 0, -0.05)), friction(0.9, 0.8));
  moved.detail = nullptr;
  EXPECT_NEAR(before.force.friction.x, -kStiffness * 0.0005, 1e-6);
  VirtualServo carried(press, kConfig);
  const ServoObject first = with(slab(), friction(0.9, 0.8));
  carried.adopt(sceneOf(1, {first}));
  carried.run(400);
  moved = slab(1, Vec3(0.0005, 0, -0.05));
  moved.detail = first.detail;
  carried.adopt(sceneOf(2, {moved}));
  const TelemetrySample after = carried.run(300);
  EXPECT_NEAR(after.stickingPoint.x - before.stickingPoint.x, 0.0005, 1e-9);
  EXPECT_NEAR(after.force.friction.x, 0, 1e-6);
}

TEST(SurfaceProperties, TextureIsFeltOnBumpsOutsideOfTheSurfaceAndNotInPits) {
  // h from 0 to 0.4 mm, highest at x = 0 and every 4 mm, with the HIP 0.2 mm above the polygons.
  const auto above = [](std::uint64_t tick) { return Vec3(-0.04 + 2e-5 * static_cast<double>(tick), 0.0123, 0.0002); };
  VirtualServo servo(above, kConfig);
  servo.adopt(sceneOf(1, {withGrating(slab(), 0.004, 0.0002)}));
  servo.run(250);  // what is there at first fades in
  int felt = 0, free = 0;
  for (int i = 0; i < 2000; ++i) {
    const TelemetrySample s = servo.step();
    const double height = 0.0002 * (1 + std::cos(2 * std::numbers::pi * s.hip.x / 0.004));
    const double depth = std::max(0.0, height - 0.0002);
    EXPECT_NEAR(s.force.contact.z - s.force.damping.z, kStiffness * depth, 1e-6) << s.hip.x;
    if (std::abs(height - 0.0002) > 1e-9) {
      EXPECT_EQ(s.object, depth > 0 ? 1U : 0U);
    }
    felt += depth > 0 ? 1 : 0;
    free += depth > 0 ? 0 : 1;
  }
  EXPECT_NEAR(felt, free, 100);
  VirtualServo pits(
      [](std::uint64_t tick) {
        return Vec3(-0.04 + 2e-5 * static_cast<double>(tick), 0.0123, tick < 20 ? 0.001 : -0.0001);
      },
      kConfig);
  pits.adopt(sceneOf(1, {withGrating(slab(), 0.004, 0.0002, 1.5, {}, true)}));
  pits.run(100);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = pits.step();
    const double height = 0.0002 * std::cos(2 * std::numbers::pi * s.hip.x / 0.004);
    EXPECT_NEAR(s.height_m, height, 1e-8);
    EXPECT_NEAR(s.force.contact.z - s.force.damping.z, kStiffness * std::max(0.0, height + 0.0001), 1e-5);
  }
}

TEST(SurfaceProperties, TextureIsContinuousThroughTheSurface) {
  VirtualServo servo([](std::uint64_t tick) { return Vec3(0.0005, 0.0123, 0.001 - 1e-6 * static_cast<double>(tick)); },
                     kConfig);
  servo.adopt(sceneOf(1, {withGrating(slab(), 0.004, 0.0002)}));
  Vec3 last(0);
  for (int i = 0; i < 2000; ++i) {
    const TelemetrySample s = servo.step();
    EXPECT_LE(glm::length(s.force.contact - last), 0.0012) << s.hip.z;
    last = s.force.contact;
  }
  EXPECT_GT(last.z, 0.8 + kStiffness * 0.0003);
}

TEST(SurfaceProperties, TextureKeepsItsDirectionWhereTheHipLiesOnThePolygonsButForRounding) {
  constexpr std::uint64_t kThere = 102;
  constexpr double kTop_m = 0.05F;  // vertices are floats
  for (int i = 0; i < 200; ++i) {
    ServoObject object = withGrating(slab(), 0.004, 0.0002);
    object.pose.rotation = glm::angleAxis(0.03 * i, glm::normalize(Vec3(1, 0.1 * i, -2)));
    const double below_m = std::ldexp(1e-18, i % 16);
    VirtualServo servo(
        [&](std::uint64_t tick) {
          const double z = tick < kThere ? 1e-5 * static_cast<double>(kThere - tick) : -below_m;
          return toWorld(object.pose, Vec3(0.004 * (i % 5), 0.0123 + 1e-4 * i, kTop_m + z));
        },
        kConfig);
    servo.adopt(sceneOf(1, {object}));
    const Vec3 force = servo.run(kThere + 1).force.texture;
    EXPECT_LE(glm::distance(force, object.pose.rotation * Vec3(0, 0, kStiffness * 0.0004)), 1e-4) << i;
  }
}

TEST(SurfaceProperties, TextureGivesEquation4aSideways) {
  VirtualServo servo(strokeAlongX(0.002, 0.02), kConfig);
  servo.adopt(sceneOf(1, {withGrating(slab(), 0.003, 0.0002, 1.5)}));
  servo.run(400);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    const double q = 2 * std::numbers::pi / 0.003;
    const double height = 0.0002 * (1 + std::cos(q * s.ihip.x)), slope = -0.0002 * q * std::sin(q * s.ihip.x);
    EXPECT_NEAR(s.height_m, height, 1e-9);
    EXPECT_NEAR(s.force.texture.x, -kStiffness * 1.5 * height * slope, 1e-6);
    EXPECT_NEAR(s.force.texture.z, kStiffness * height, 1e-6);
    EXPECT_NEAR(s.force.spring.z, kStiffness * 0.002, 1e-6);
  }
}

TEST(SurfaceProperties, TheGainOfATextureIsClampedToWhatTheDeviceIsStableAt) {
  StepConfig config = kConfig;
  config.stableLateral_N_per_m = 300;
  VirtualServo servo(strokeAlongX(0.002, 0.02), config);
  const ServoObject steep = withGrating(slab(), 0.001, 0.0001, 1.5);
  // h = A (1 + cos qx): h'^2 + h h'' = A^2 q^2 (cos qx - cos 2qx ...) at most 9/8 of A^2 q^2.
  const double q = 2 * std::numbers::pi / 0.001;
  EXPECT_NEAR(steep.detail->texture->steepness(), 1.125 * 0.0001 * 0.0001 * q * q, 0.01);
  const double gain = steep.detail->texture->gainFor(kStiffness, 300);
  EXPECT_LT(gain, 1.5);
  servo.adopt(sceneOf(1, {steep}));
  servo.run(400);
  double stiffest = 0;
  TelemetrySample last = servo.step();
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    stiffest = std::max(stiffest, -(s.force.texture.x - last.force.texture.x) / (s.ihip.x - last.ihip.x));
    last = s;
  }
  EXPECT_LE(stiffest, 303);
  EXPECT_GE(stiffest, 280);
}

/// Over the top of a coarse sphere.
Vec3 overSphere(std::uint64_t tick) {
  const double down = std::min(1.0, static_cast<double>(tick) / 200);
  const double angle = tick > 300 ? 1e-4 * static_cast<double>(tick - 300) / 0.05 : 0;
  return (0.052 - 0.004 * down) * glm::normalize(Vec3(std::sin(angle), 0.2, std::cos(angle)));
}

TEST(SurfaceProperties, ShadingMakesACoarseSphereRound) {
  const ServoObject sphere = objectOf(1, surfaceOf(makeSphere(0.05, 12).value()), Vec3(0));
  VirtualServo servo(overSphere, kConfig);
  servo.adopt(sceneOf(1, {with(sphere, shading(std::numbers::pi))}));
  servo.run(500);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    const Vec3 out = glm::normalize(s.hip);
    EXPECT_LE(glm::length(s.surfaceNormal - out), 1e-5);
    EXPECT_NEAR(s.penetration_m, 0.002, 2e-6);
    EXPECT_LE(glm::distance(s.ihip, 0.05 * out), 2e-6);
  }
}

TEST(SurfaceProperties, ShadingEndsWithoutAStepWhereAWallStopsTheIhipBetweenTheLinesOfACoarseSphere) {
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

TEST(SurfaceProperties, ShadingKeepsTheRimOfACylinderSharp) {
  SurfaceProperties properties = shading(std::numbers::pi / 3);
  const ServoObject cylinder = with(objectOf(1, surfaceOf(makeCylinder(0.02, 0.08, 48).value()), Vec3(0)), properties);
  const auto pressOn = [&](Vec3 place, Vec3 inward) {
    VirtualServo servo(
        [=](std::uint64_t tick) { return place + inward * std::min(0.0004, 2e-5 * static_cast<double>(tick) - 0.002); },
        kConfig);
    servo.adopt(sceneOf(1, {cylinder}));
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

TEST(SurfaceProperties, ShadingGoesOverToAnInnerEdgeAndOutWithoutAStep) {
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

TEST(SurfaceProperties, AllFeaturesTogetherAllocateNothing) {
  SurfaceProperties all = friction(0.5, 0.3);
  all.shading = shading(1).shading;
  const auto up = [](std::uint64_t tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    return Vec3(0.02 * std::sin(t), 0.0123, 0.0015 * std::cos(9 * t));
  };
  VirtualServo servo(up, kConfig);
  const std::shared_ptr<const ServoScene> scene = sceneOf(1, {withGrating(slab(), 0.003, 0.0002, 1.5, all)});
  servo.adopt(scene);
  const std::uint64_t before = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    servo.run(3000);
  }
  EXPECT_EQ(AllocationTripwire::count(), before);
}

TEST(SurfaceProperties, ATextureInWhichTheStylusAppearsFadesIn) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0001); }, kConfig);
  servo.adopt(sceneOf(1, {withGrating(slab(), 0.004, 0.0003)}));
  double last = 0;
  for (int i = 0; i < 100; ++i) {
    const double now = servo.step().force.contact.z;
    EXPECT_LE(now - last, 0.02);
    last = now;
  }
  EXPECT_NEAR(last, kStiffness * 0.0005, 1e-6);
}

class SurfaceEdit : public ::testing::Test {
 protected:
  struct Steps {
    double contact_N = 0;  ///< Before blend and limit.
    double written_N = 0;
  };
  /// Largest steps of the force around an edit under the stylus, less the largest that either scene has by itself.
  static Steps steps(const ServoObject& before, const ServoObject& after) {
    const Steps edited = largest(before, after), first = largest(before, before), second = largest(after, after);
    return {edited.contact_N - std::max(first.contact_N, second.contact_N),
            edited.written_N - std::max(first.written_N, second.written_N)};
  }

 private:
  static Steps largest(const ServoObject& before, const ServoObject& after) {
    VirtualServo servo(strokeAlongX(0.002, 0.02), kConfig);
    servo.adopt(sceneOf(1, {before}));
    servo.run(600);
    Steps steps;
    ForceComponents last = servo.step().force;
    servo.adopt(sceneOf(2, {after}));
    for (int i = 0; i < 300; ++i) {
      const ForceComponents now = servo.step().force;
      steps.contact_N = std::max(steps.contact_N, glm::length(now.contact - last.contact));
      steps.written_N = std::max(steps.written_N, glm::length(now.written - last.written));
      last = now;
    }
    return steps;
  }
};

TEST_F(SurfaceEdit, ThatAddsATextureMakesNoStep) {
  const Steps added = steps(slab(), withGrating(slab(), 0.003, 0.0002));
  EXPECT_LE(added.contact_N, 0.02);
  EXPECT_LE(added.written_N, 0.02);
}

TEST_F(SurfaceEdit, OfATexturesAmplitudeMakesNoStep) {
  EXPECT_LE(steps(withGrating(slab(), 0.003, 0.0002), withGrating(slab(), 0.003, 0.0004)).contact_N, 0.03);
  for (const double amplitude : {0.0004, 0.0001}) {
    const Steps changed = steps(withGrating(slab(), 0.003, 0.0002), withGrating(slab(), 0.003, amplitude));
    EXPECT_LE(changed.written_N, 0.03) << amplitude;
  }
}

TEST_F(SurfaceEdit, OfATexturesFieldOrItsRemovalMakesNoStepOfTheForceThatIsWritten) {
  EXPECT_LE(steps(withGrating(slab(), 0.003, 0.0002), slab()).written_N, 0.02);
  EXPECT_LE(steps(withGrating(slab(), 0.003, 0.0002), withGrating(slab(), 0.004, 0.0005)).written_N, 0.03);
}

TEST_F(SurfaceEdit, OfFrictionMakesNoStep) {
  EXPECT_LE(steps(slab(), with(slab(), friction(0.8, 0.8))).contact_N, 0.03);
  EXPECT_LE(steps(with(slab(), friction(0.8, 0.8)), slab()).written_N, 0.03);
  for (const double mu : {0.2, 1.2}) {
    const Steps changed = steps(with(slab(), friction(0.6, 0.6)), with(slab(), friction(mu, mu)));
    EXPECT_LE(changed.contact_N, 0.03) << mu;
    EXPECT_LE(changed.written_N, 0.03) << mu;
  }
}

TEST_F(SurfaceEdit, ToATallerTextureIsFeltByAStylusThatHoversOverIt) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0005); }, kConfig);
  servo.adopt(sceneOf(1, {withGrating(slab(), 0.004, 0.0001)}));
  EXPECT_EQ(servo.run(100).object, 0U);
  servo.adopt(sceneOf(2, {withGrating(slab(), 0.004, 0.0004)}));
  const TelemetrySample after = servo.run(100);
  EXPECT_EQ(after.object, 1U);
  EXPECT_NEAR(after.force.contact.z, kStiffness * 0.0003, 1e-6);
}

TEST_F(SurfaceEdit, OfThePoseMakesNoStepWhereOnlyABumpReachesTheStylus) {
  const ServoObject object = withGrating(slab(), 0.004, 0.0004);
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0005); }, kConfig);
  servo.adopt(sceneOf(1, {object}));
  double last = servo.run(100).force.written.z;
  EXPECT_NEAR(last, kStiffness * 0.0003, 1e-6);
  ServoObject lower = object;
  lower.pose.position.z -= 0.0002;
  servo.adopt(sceneOf(2, {lower}));
  for (int i = 0; i < 100; ++i) {
    const double now = servo.step().force.written.z;
    EXPECT_LE(std::abs(now - last), 0.01);
    last = now;
  }
  EXPECT_NEAR(last, kStiffness * 0.0001, 1e-6);
}

TEST_F(SurfaceEdit, ThatBringsFrictionBackKnowsNothingOfTheOldStickingPoint) {
  VirtualServo servo(strokeAlongX(0.002, 0.02), kConfig);
  servo.adopt(sceneOf(1, {with(slab(), friction(0.9, 0.9))}));
  servo.run(500);
  servo.adopt(sceneOf(2, {slab()}));
  servo.run(500);
  servo.adopt(sceneOf(3, {with(slab(), friction(0.9, 0.9))}));
  EXPECT_LE(glm::length(servo.step().force.friction), 0.05);
}

TEST_F(SurfaceEdit, OfShadingMakesNoStep) {
  const auto largest = [](bool before, bool after) {
    const ServoObject faceted = objectOf(1, surfaceOf(makeSphere(0.05, 5).value()), Vec3(0));
    const ServoObject round = with(faceted, shading(std::numbers::pi));
    VirtualServo servo(overSphere, kConfig);
    servo.adopt(sceneOf(1, {before ? round : faceted}));
    servo.run(700);
    double most = 0;
    Vec3 last = servo.step().force.written;
    servo.adopt(sceneOf(2, {after ? round : faceted}));
    for (int i = 0; i < 100; ++i) {  // not as far as the next line
      const Vec3 now = servo.step().force.written;
      most = std::max(most, glm::length(now - last));
      last = now;
    }
    return most;
  };
  EXPECT_LE(largest(false, true), largest(true, true) + 0.03);
  EXPECT_LE(largest(true, false), std::max(largest(true, true), largest(false, false)) + 0.03);
}

TEST_F(SurfaceEdit, OfTheMeshKeepsTheStickingPoint) {
  const auto press = [](std::uint64_t tick) {
    return Vec3(tick > 300 ? 0.0005 : 0, 0.0123, std::max(-0.002, 0.003 - 5e-5 * static_cast<double>(tick)));
  };
  VirtualServo servo(press, kConfig);
  servo.adopt(sceneOf(1, {with(slab(), friction(0.9, 0.8))}));
  const TelemetrySample before = servo.run(400);
  const ServoObject finer = objectOf(1, surfaceOf(makeBox(Vec3(0.1), 20).value()), Vec3(0, 0, -0.05));
  servo.adopt(sceneOf(2, {with(finer, friction(0.9, 0.8))}));
  const TelemetrySample after = servo.run(100);
  EXPECT_EQ(after.sceneRevision, 2U);
  EXPECT_EQ(after.frictionState, FrictionState::kSticking);
  EXPECT_LE(glm::distance(after.stickingPoint, before.stickingPoint), 1e-7);
  EXPECT_LE(glm::distance(after.force.friction, before.force.friction), 1e-3);
}

}  // namespace
}  // namespace haptics
