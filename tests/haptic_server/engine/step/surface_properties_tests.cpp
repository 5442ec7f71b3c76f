// Section 4 of the paper in the production step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/surface/grown_field.h"
#include "common/surface/make_field.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::surface_properties_tests {
namespace {

using namespace fixture;

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
  VirtualServo servo(strokeAlongX(0.002, 0.005), kConfig, sceneOf(1, {with(slab(), friction(0.6, 0.3))}));
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
  EXPECT_LT(sample.energyGiven_J[static_cast<std::size_t>(EnergyFeature::kFriction)], 0);
}

TEST(SurfaceProperties, FrictionFollowsAFieldOverTheSurface) {
  SurfaceProperties properties = friction(0.6, 0.3);
  properties.friction->variation = 0.5;
  properties.friction->over = FieldFamily{FourierFamily{}};
  VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig,
                     sceneOf(1, {with(slab(), properties, {nullptr, fixture::gratingField(0.01), nullptr})}));
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
  VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig,
                     sceneOf(1, {with(box, friction(0.6, 0.3), {nullptr, nullptr, scale})}));
  servo.run(500);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = servo.step();
    const double normal_N = s.force.spring.z + s.force.damping.z;
    EXPECT_NEAR(-s.force.friction.x / normal_N, 0.3 * (1 + 10 * s.ihip.x), 0.0015) << s.ihip.x;
  }
}

/// mu_static from 0.3 to 0.9 and mu_dynamic from 0.15 to 0.45, waves of 10 mm and 7 mm across x.
ServoObject withTwoFrictionMaps() {
  SurfaceProperties properties = friction(0.6, 0.3);
  properties.friction->variation = properties.friction->dynamicVariation = 0.5;
  properties.friction->over = properties.friction->dynamicOver = FieldFamily{FourierFamily{}};
  return with(slab(), properties,
              {.texture = nullptr,
               .friction = fixture::gratingField(0.01),
               .frictionScale = nullptr,
               .dynamicFriction = fixture::gratingField(0.007)});
}
double wavy(double mean, double x, double wavelength_m) {
  return mean * (1 + 0.5 * std::cos(2 * std::numbers::pi * x / wavelength_m));
}

TEST(SurfaceProperties, FrictionBreaksAwayAndSlidesByAMapOfEachCoefficient) {
  for (double start = -0.04; start < 0.03; start += 0.0013) {
    VirtualServo servo(
        [&](std::uint64_t tick) {
          const double t = static_cast<double>(tick);
          return Vec3(start + 2e-6 * std::max(0.0, t - 300), 0.0123, 0.003 - 0.005 * std::min(1.0, t / 200));
        },
        kConfig, sceneOf(1, {withTwoFrictionMaps()}));
    double broke = 0;
    for (int i = 0; i < 4000; ++i) {
      const TelemetrySample s = servo.step();
      const double ratio = glm::length(s.force.friction) / (s.force.spring.z + s.force.damping.z);
      if (i > 300 && s.frictionState == FrictionState::kSticking) broke = ratio;
      if (s.frictionState != FrictionState::kSliding) continue;
      const double slides = std::min(wavy(0.3, s.ihip.x, 0.007), wavy(0.6, s.ihip.x, 0.01));
      ASSERT_NEAR(ratio, slides, 0.01 * slides) << s.ihip.x;
    }
    EXPECT_NEAR(broke, wavy(0.6, start, 0.01), 0.01 * wavy(0.6, start, 0.01)) << start;
  }
}

TEST(SurfaceProperties, TheDynamicCoefficientFollowsValuesPerVertexOfItsOwn) {
  auto scale = std::make_shared<std::vector<float>>();
  const TriMesh mesh = makeBox(Vec3(0.1), 8).value();
  for (const Vec3f v : mesh.vertices) scale->push_back(1 + 10 * v.x);  // from 0.5 to 1.5
  DetailFields fields;
  fields.dynamicFrictionScale = scale;
  VirtualServo servo(strokeAlongX(0.002, 0.05), kConfig, sceneOf(1, {with(slab(), friction(0.4, 0.3), fields)}));
  servo.run(500);
  for (int i = 0; i < 1500; ++i) {
    const TelemetrySample s = servo.step();
    const double normal_N = s.force.spring.z + s.force.damping.z;
    EXPECT_NEAR(-s.force.friction.x / normal_N, std::min(0.4, 0.3 * (1 + 10 * s.ihip.x)), 0.0015) << s.ihip.x;
  }
}

TEST(SurfaceProperties, FrictionWithTwoMapsStepsNoMoreThanWithOneOfBoth) {
  // To and fro, each time around another place.
  const auto path = [](std::uint64_t tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    return Vec3(0.03 * std::sin(0.7 * t) + 0.004 * std::sin(9 * t), 0.0123, 0.003 - 0.005 * std::min(1.0, 5 * t));
  };
  struct Run {
    double largest_N = 0;  // step, but of breaking away, which is one
    int stuckAgain = 0;
  };
  const auto run = [&](const ServoObject& object) {
    VirtualServo servo(path, kConfig, sceneOf(1, {object}));
    TelemetrySample last = servo.run(300);
    Run result;
    for (int i = 0; i < 20'000; ++i) {
      const TelemetrySample s = servo.step();
      const bool wasSliding = last.frictionState == FrictionState::kSliding;
      const bool slides = s.frictionState == FrictionState::kSliding;
      result.stuckAgain += wasSliding && !slides ? 1 : 0;
      const double step_N = glm::length(s.force.friction - last.force.friction);
      if (wasSliding || !slides) result.largest_N = std::max(result.largest_N, step_N);
      last = s;
    }
    return result;
  };
  SurfaceProperties one = friction(0.6, 0.3);
  one.friction->variation = 0.5;
  const Run equal = run(with(slab(), one, {nullptr, fixture::gratingField(0.01), nullptr}));
  const Run different = run(withTwoFrictionMaps());
  EXPECT_GT(equal.stuckAgain, 20);
  EXPECT_GT(different.stuckAgain, 20);
  // It does not stick in quite the same places, where the spring is as stiff as the static coefficient there.
  EXPECT_LE(different.largest_N, 1.05 * equal.largest_N);
}

TEST(SurfaceProperties, ATextureOfLayersHasTheHeightOfTheirSum) {
  const auto wave = [](double wavelength_m) { return FourierFamily{{{1, Vec3(1, 0, 0), wavelength_m, 0}}}; };
  const LayeredFamily layers{LayeredFamily::Combination::kSum, {{1, wave(0.011)}, {-0.3, wave(0.002)}}};
  SurfaceProperties properties;
  properties.texture = Texture{.family = layers, .amplitude_m = 0.0002};
  VirtualServo servo(
      strokeAlongX(0.002, 0.02), kConfig,
      sceneOf(1, {with(slab(), properties,
                       {.texture = makeField(layers, {}).value(), .friction = nullptr, .frictionScale = nullptr})}));
  servo.run(400);
  double lowest_m = 1, highest_m = 0;
  for (int i = 0; i < 2000; ++i) {
    const TelemetrySample s = servo.step();
    const double turns = 2 * std::numbers::pi * s.ihip.x;
    const double height_m = 0.0002 * (1.3 + std::cos(turns / 0.011) - 0.3 * std::cos(turns / 0.002));
    EXPECT_NEAR(s.height_m, height_m, 1e-9 + 0.01 * height_m) << s.ihip.x;
    EXPECT_NEAR(s.force.texture.z, kStiffness * height_m, 1e-6 + 0.01 * kStiffness * height_m) << s.ihip.x;
    lowest_m = std::min(lowest_m, s.height_m);
    highest_m = std::max(highest_m, s.height_m);
  }
  EXPECT_LT(lowest_m, 0.0001);
  EXPECT_GT(highest_m, 0.0004);
}

TEST(SurfaceProperties, AGrownTextureIsFeltAtItsHeightWithoutAllocating) {
  std::vector<PointSample> samples;
  for (int y = 6; y < 18; ++y) {
    for (int x = -60; x <= 60; ++x) {
      const auto value = static_cast<float>(std::cos(2 * std::numbers::pi * x / 8));
      samples.push_back({Vec3f(1e-3F * static_cast<float>(x), 1e-3F * static_cast<float>(y), 0.05F), value + 0.0F});
    }
  }
  const auto field =
      std::make_shared<const GrownField>(std::make_shared<const PointField>(PointField::make(0.002F, samples).value()));
  SurfaceProperties properties;
  properties.texture = Texture{.family = GrownFamily{}, .amplitude_m = 0.0002};
  VirtualServo servo(
      strokeAlongX(0.002, 0.02), kConfig,
      sceneOf(1, {with(slab(), properties, {.texture = field, .friction = nullptr, .frictionScale = nullptr})}));
  servo.run(400);
  double lowest_m = 1, highest_m = 0, worst_m = 0;
  const std::uint64_t before = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    for (int i = 0; i < 2000; ++i) {
      const TelemetrySample s = servo.step();
      const double height_m = 0.0002 * (field->at(s.ihip + Vec3(0, 0, 0.05)).value - field->lowest());
      worst_m = std::max(worst_m, std::abs(s.height_m - height_m));
      lowest_m = std::min(lowest_m, s.height_m);
      highest_m = std::max(highest_m, s.height_m);
    }
  }
  EXPECT_EQ(AllocationTripwire::count(), before);
  EXPECT_LT(worst_m, 2e-6);
  EXPECT_LT(lowest_m, 0.00008);
  EXPECT_GT(highest_m, 0.0003);
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
  VirtualServo servo(pressThenAside, kConfig);
  const ServoObject first = with(slab(), friction(0.9, 0.8));
  servo.adopt(sceneOf(1, {first}));
  const TelemetrySample before = servo.run(400);
  EXPECT_NEAR(before.force.friction.x, -kStiffness * 0.0005, 1e-6);
  ServoObject moved = slab(1, Vec3(0.0005, 0, -0.05));
  moved.detail = first.detail;
  servo.adopt(sceneOf(2, {moved}));
  const TelemetrySample after = servo.run(300);
  EXPECT_NEAR(after.stickingPoint.x - before.stickingPoint.x, 0.0005, 1e-9);
  EXPECT_NEAR(after.force.friction.x, 0, 1e-6);
}

TEST(SurfaceProperties, TextureIsFeltOnBumpsOutsideOfTheSurfaceAndNotInPits) {
  // h from 0 to 0.4 mm, highest at x = 0 and every 4 mm, with the HIP 0.2 mm above the polygons.
  const auto above = [](std::uint64_t tick) { return Vec3(-0.04 + 2e-5 * static_cast<double>(tick), 0.0123, 0.0002); };
  VirtualServo servo(above, kConfig, sceneOf(1, {withGrating(slab(), 0.004, 0.0002)}));
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
      kConfig, sceneOf(1, {withGrating(slab(), 0.004, 0.0002, 1.5, {}, true)}));
  pits.run(100);
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample s = pits.step();
    const double height = 0.0002 * std::cos(2 * std::numbers::pi * s.hip.x / 0.004);
    EXPECT_NEAR(s.height_m, height, 1e-8);
    EXPECT_NEAR(s.force.contact.z - s.force.damping.z, kStiffness * std::max(0.0, height + 0.0001), 1e-5);
  }
}

TEST(SurfaceProperties, BumpsForWhichTheAllowanceIsShortAreLeftOutWithoutAStep) {
  constexpr std::uint64_t kBodies = 6;
  std::vector<ServoObject> slabs;
  SurfaceProperties properties;
  properties.texture = fixture::acrossDepth();
  constexpr double kLower_m = 0.0003;  // the last one, which is looked at last, is felt first
  for (std::uint64_t id = 1; id <= kBodies; ++id) {
    const Vec3 at(0, 0, id < kBodies ? -0.05 - kLower_m : -0.05);
    slabs.push_back(with(slab(id, at), properties, {fixture::depthField(), nullptr, nullptr}));
  }
  const auto down = [](std::uint64_t tick) {  // to 0.4 mm above the polygons, over which there are bumps of 1 mm
    return Vec3(0.011, 0.0123, 0.0004 + 0.002 * std::max(0.0, 1 - static_cast<double>(tick) / 1000));
  };
  const auto run = [&](double units) {
    StepConfig config = kConfig;
    config.work_per_s = units / config.period_s;
    VirtualServo servo(down, config, sceneOf(1, slabs));
    double before_N = 0, step_N = 0;
    for (int i = 0; i < 2000; ++i) {
      const double force_N = servo.step().force.written.z;
      step_N = std::max(step_N, std::abs(force_N - before_N));
      before_N = force_N;
    }
    EXPECT_LE(step_N, 0.031) << units << " units";  // 30 N/s
    return std::pair(before_N, servo.state().report.allowanceSpent);
  };
  const auto [all_N, noneBehind] = run(1e9);
  const auto [some_N, behind] = run(3000);
  EXPECT_NEAR(all_N, kStiffness * (kBodies * 0.0006 - (kBodies - 1) * kLower_m), 0.02 * all_N);
  EXPECT_EQ(noneBehind, 0U);
  EXPECT_GT(behind, 100U);
  EXPECT_GT(some_N, 0);
  EXPECT_LT(some_N, 0.7 * all_N);
}

TEST(SurfaceProperties, TextureIsContinuousThroughTheSurface) {
  VirtualServo servo([](std::uint64_t tick) { return Vec3(0.0005, 0.0123, 0.001 - 1e-6 * static_cast<double>(tick)); },
                     kConfig, sceneOf(1, {withGrating(slab(), 0.004, 0.0002)}));
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
        kConfig, sceneOf(1, {object}));
    const Vec3 force = servo.run(kThere + 1).force.texture;
    EXPECT_LE(glm::distance(force, object.pose.rotation * Vec3(0, 0, kStiffness * 0.0004)), 1e-4) << i;
  }
}

TEST(SurfaceProperties, TextureGivesEquation4aSideways) {
  VirtualServo servo(strokeAlongX(0.002, 0.02), kConfig, sceneOf(1, {withGrating(slab(), 0.003, 0.0002, 1.5)}));
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

TEST(SurfaceProperties, BumpsAreSidewaysNoStifferThanTheDeviceIsStableAt) {
  const auto stiffest = [](double most) {
    StepConfig config = kConfig;
    config.stableLateral_N_per_m = most;
    VirtualServo servo(strokeAlongX(0.002, 0.02), config);
    SurfaceProperties properties;
    properties.texture = Texture{.family = FourierFamily{}, .amplitude_m = 0.0001};
    properties.texture->law = Texture::Law::kBump;
    servo.adopt(sceneOf(1, {with(slab(), properties, {fixture::gratingField(0.001), nullptr, nullptr})}));
    servo.run(400);
    double found = 0;
    TelemetrySample last = servo.step();
    for (int i = 0; i < 1000; ++i) {
      const TelemetrySample s = servo.step();
      found = std::max(found, -(s.force.texture.x - last.force.texture.x) / (s.ihip.x - last.ihip.x));
      last = s;
    }
    return found;
  };
  EXPECT_GT(stiffest(std::numeric_limits<double>::infinity()), 3000);
  EXPECT_LE(stiffest(300), 303);
  EXPECT_GE(stiffest(300), 200);
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
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0001); }, kConfig,
                     sceneOf(1, {withGrating(slab(), 0.004, 0.0003)}));
  double last = 0;
  for (int i = 0; i < 100; ++i) {
    const double now = servo.step().force.contact.z;
    EXPECT_LE(now - last, 0.02);
    last = now;
  }
  EXPECT_NEAR(last, kStiffness * 0.0005, 1e-6);
}

constexpr double kPull_N = 1;

ServoObject sticky(ServoObject object, double pull_N = kPull_N) {
  SurfaceProperties properties;
  properties.scalars.adhesion_N = pull_N;
  return with(std::move(object), properties);
}

TEST(SurfaceProperties, AdhesionPullsToTheSurfaceWithinAMillimetreOfIt) {
  const auto height_m = [](std::uint64_t tick) { return 0.0020005 - 1e-6 * double(tick < 2000 ? tick : 4000 - tick); };
  VirtualServo servo([&](std::uint64_t tick) { return Vec3(0.003, 0.0123, height_m(tick)); }, kConfig,
                     sceneOf(1, {sticky(slab())}));
  double work_J = 0;
  for (std::uint64_t tick = 0; tick < 4000; ++tick) {
    const Vec3 force = servo.step().force.written;
    const double z = height_m(tick);
    const double share = std::clamp(std::min(z, 1e-3 - z) / 0.25e-3, 0.0, 1.0);
    EXPECT_NEAR(glm::distance(force, Vec3(0, 0, -kPull_N * share)), 0, 1e-5) << z;
    work_J += force.z * (height_m(tick + 1) - z);
  }
  EXPECT_NEAR(work_J, 0, 1e-8);
}

/// Across a valley of two sheets, around a line, at rest, and through a soft plate and past its edge.
TEST(SurfaceProperties, AdhesionHasNoStep) {
  const auto valley = surfaceOf({{{-0.05F, -0.05F, 0.05F},
                                  {0, -0.05F, 0},
                                  {0.05F, -0.05F, 0.05F},
                                  {-0.05F, 0.05F, 0.05F},
                                  {0, 0.05F, 0},
                                  {0.05F, 0.05F, 0.05F}},
                                 {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}}});
  const auto along = [](Vec3 from, Vec3 to) {
    return [=](std::uint64_t tick) { return glm::mix(from, to, std::min(1.0, double(tick) / 1000)); };
  };
  const auto plate = surfaceOf(makeBox(Vec3(0.1, 0.1, 2e-4), 1).value());
  const auto slip = [](std::uint64_t tick) {
    const double down = std::min(1.0, double(tick) / 500), beside = std::clamp(double(tick) / 500 - 1, 0.0, 1.0);
    return Vec3(0.049 + 0.0015 * beside, 0.0123, 0.002 - 0.0026 * down);
  };
  const std::pair<VirtualServo::Trajectory, ServoObject> cases[] = {
      {along({-0.005, 0.002, 0.006}, {0.005, 0.002, 0.006}), sticky(objectOf(1, valley, Vec3(0)))},
      {along({-0.001, 0.002, 0.0011}, {0.001, 0.002, 0.0011}), sticky(objectOf(1, valley, Vec3(0)))},
      {along({0.0495, 0.002, 0.0007}, {0.0507, 0.002, -0.0005}), sticky(slab())},
      {along({0, 0.002, 0.0005}, {0, 0.002, 0.0005}), sticky(slab())},
      {slip, sticky(objectOf(1, plate, Vec3(0), 20))}};
  const StepConfig config{.period_s = 1e-3, .maxForce_N = 1e9, .stableLateral_N_per_m = 1e4};
  for (const auto& [trajectory, object] : cases) {
    VirtualServo servo(trajectory, config, sceneOf(1, {object}));
    Vec3 last{0};
    double most_N = 0;
    const auto follow = [&](int ticks) {
      for (int i = 0; i < ticks; ++i) {
        const double way_m = glm::distance(trajectory(servo.tick()), trajectory(servo.tick() + 1));
        const Vec3 now = servo.step().force.written;
        EXPECT_LE(glm::distance(now, last), 0.032 + (kStiffness + 2 * kPull_N / 0.25e-3) * way_m) << servo.tick();
        most_N = std::max(most_N, glm::length(now));
        last = now;
      }
    };
    follow(1200);
    EXPECT_GT(most_N, 0.9 * kPull_N);
    servo.adopt(sceneOf(2, {sticky(object, 2)}));
    follow(200);
    ServoObject removed = sticky(object, 2);
    removed.pendingRemoval = true;
    servo.adopt(sceneOf(3, {removed}));
    follow(500);
    EXPECT_EQ(last, Vec3(0));
  }
}

TEST(SurfaceProperties, AdhesionIsNoStifferThanTheDeviceBears) {
  const StepConfig config{.period_s = 1e-3, .maxForce_N = 1e9, .stableLateral_N_per_m = 1000};
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0005); }, config, sceneOf(1, {sticky(slab(), 2)}));
  EXPECT_NEAR(servo.run(200).force.written.z, -1000 * 0.25e-3, 1e-9);
}

}  // namespace
}  // namespace haptics::surface_properties_tests
