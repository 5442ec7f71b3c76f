#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "common/surface/make_field.h"
#include "haptic_server/engine/step/varying_springs.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "tests/haptic_server/engine/step/surface_world.h"

// Stiffness and softness that vary over a surface.
namespace haptics::varying_springs_tests {
namespace {

using namespace fixture;

constexpr double kTissue_N_per_m = 500;
constexpr double kDepth_m = 0.003;

/// Waves of 25 mm and more in all directions of the plane, f from -1 to 1.
std::shared_ptr<const ScalarField> smoothField(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), length_m(0.025, 0.06);
  FourierFamily family;
  for (int i = 0; i < 4; ++i) {
    const double way = turn(random);
    family.terms.push_back({0.25, Vec3(std::cos(way), std::sin(way), 0), length_m(random), turn(random)});
  }
  return std::make_shared<FourierField>(family);
}

struct Maps {
  FactorSource stiffness = {}, softness = {};
  double variation = 0.8;
};

ServoObject blockWith(const Maps& maps, double tissue_N_per_m = 0, SurfaceProperties properties = {}) {
  ServoObject block = objectOf(1, fineBlock(), Vec3(0, 0, -0.05));
  block.damping_Ns_per_m = 0;
  DetailFields fields;
  fields.stiffness = maps.stiffness;
  fields.softness = maps.softness;
  const auto mapOf = [&](const FactorSource& source) -> std::optional<SurfaceMap> {
    if (source.field) return SurfaceMap{maps.variation, FieldFamily{FourierFamily{}}};
    if (source.scale) return SurfaceMap{0, PerVertexScale{}};
    return std::nullopt;
  };
  properties.stiffnessOver = mapOf(maps.stiffness);
  properties.softnessOver = mapOf(maps.softness);
  if (tissue_N_per_m > 0) {
    block.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.03, 2), tissue_N_per_m, 0});
  }
  return with(block, properties, fields);
}

double factorAt(const std::shared_ptr<const ScalarField>& field, double variation, Vec3 place) {
  return field ? 1 + variation * field->at(place).value : 1;
}

/// Down at a place within 200 ticks.
VirtualServo::Trajectory downAt(Vec3 place, double depth_m = kDepth_m) {
  return [=](std::uint64_t tick) {
    return place + Vec3(0, 0, 0.002 - (0.002 + depth_m) * std::min(1.0, static_cast<double>(tick) / 200));
  };
}

const Vec3 kPlaces[] = {
    {-0.031, 0.0123, 0}, {-0.011, -0.02, 0}, {0.0047, 0.003, 0}, {0.0208, -0.0311, 0}, {0.03, 0.02, 0}};

TEST(VaryingSprings, PushWithTheStiffnessOfThePlaceAndToWhereItIsSofter) {
  const auto field = smoothField(1);
  for (const Vec3& place : kPlaces) {
    VirtualServo servo(downAt(place), kConfig, sceneOf(1, {blockWith({.stiffness = {field}})}));
    const Vec3 force = servo.run(300).force.spring;
    // In the object's frame the top is at z = 50 mm.
    const FieldSample f = field->at(place + Vec3(0, 0, 0.05));
    const double normal_N = kStiffness * (1 + 0.8 * f.value) * kDepth_m;
    EXPECT_NEAR(force.z, normal_N, 0.01 * normal_N) << place.x;
    const Vec3 aside_N = -kStiffness * 0.8 * kDepth_m * kDepth_m / 2 * f.gradient;
    EXPECT_NEAR(force.x, aside_N.x, 0.01 * normal_N) << place.x;
    EXPECT_NEAR(force.y, aside_N.y, 0.01 * normal_N) << place.x;
  }
}

TEST(VaryingSprings, PushByValuesPerVertexLinearInBetweenAndNoLessThanTheLeast) {
  auto scale = std::make_shared<std::vector<float>>();
  const TriMesh mesh = makeBox(Vec3(0.1), 60).value();
  for (const Vec3f v : mesh.vertices) {
    scale->push_back(std::max(0.0F, 1 + 40 * v.x));  // 0 from x = -25 mm down
  }
  for (const Vec3& place : kPlaces) {
    VirtualServo servo(downAt(place), kConfig, sceneOf(1, {blockWith({.stiffness = {nullptr, scale}})}));
    const Vec3 force = servo.run(300).force.spring;
    const double factor = std::max(kMinStiffnessFactor, 1 + 40 * place.x);
    EXPECT_NEAR(force.z, kStiffness * factor * kDepth_m, 0.01 * kStiffness * factor * kDepth_m) << place.x;
    const double slope = factor > kMinStiffnessFactor ? 40 : 0;
    EXPECT_NEAR(force.x, -kStiffness * slope * kDepth_m * kDepth_m / 2, 1e-6) << place.x;
    EXPECT_NEAR(force.y, 0, 1e-6);
  }
}

TEST(VaryingSprings, AreInSeriesWithTissueThatVariesToo) {
  const auto stiffness = smoothField(2), softness = smoothField(3);
  for (const Maps& maps : {Maps{.stiffness = {stiffness}}, Maps{.softness = {softness}},
                           Maps{.stiffness = {stiffness}, .softness = {softness}}}) {
    for (const Vec3& place : kPlaces) {
      VirtualServo servo(downAt(place), kConfig, sceneOf(1, {blockWith(maps, kTissue_N_per_m)}));
      const double force_N = servo.run(300).force.spring.z;
      const Vec3 onBlock = place + Vec3(0, 0, 0.05);
      const double k = kStiffness * factorAt(maps.stiffness.field, 0.8, onBlock);
      const double t = kTissue_N_per_m * factorAt(maps.softness.field, 0.8, onBlock);
      const double expected_N = kDepth_m / (1 / k + 1 / t);
      EXPECT_NEAR(force_N, expected_N, 0.02 * expected_N) << place.x;
    }
  }
}

TEST(VaryingSprings, AreNowhereStifferThanTheDeviceBears) {
  const auto field = gratingField(0.04);
  ServoObject block = blockWith({.stiffness = {field}});
  block.highestFactor = 1.25;
  for (const double x : {0.0, 0.004, 0.012, 0.02}) {
    VirtualServo servo(downAt({x, 0.0123, 0}), kConfig, sceneOf(1, {block}));
    const Vec3 force = servo.run(300).force.spring;
    const double factor = 1 + 0.8 * std::cos(2 * std::numbers::pi * x / 0.04);
    EXPECT_NEAR(force.z, kStiffness * std::min(factor, 1.25) * kDepth_m, 1e-6) << x;
    if (factor > 1.25) {
      EXPECT_NEAR(force.x, 0, 1e-9) << x;
    }
  }
}

TEST(VaryingSprings, DampInTheSameRatio) {
  const auto field = gratingField(0.04);
  ServoObject block = blockWith({.stiffness = {field}});
  block.damping_Ns_per_m = 2;
  for (const double x : {0.0, 0.02}) {
    VirtualServo servo(downAt({x, 0.0123, 0}), kConfig, sceneOf(1, {block}));
    const TelemetrySample pressing = servo.run(150);  // at 25 mm/s
    const double factor = 1 + 0.8 * std::cos(2 * std::numbers::pi * x / 0.04);
    EXPECT_NEAR(pressing.force.damping.z, 2 * factor * 0.025, 0.002) << x;
  }
}

// ---- Energy ----

/// Joules that the hand gets along a closed way, by the trapezoidal rule: the force as a field over the place, without what
/// holding it for a tick adds.
double loop_J(VirtualServo& servo, const VirtualServo::Trajectory& path, std::uint64_t ticks) {
  Vec3 at = path(servo.tick() - 1);
  Vec3 before_N = servo.state().limits.unlimited_N;
  double work_J = 0;
  for (std::uint64_t i = 0; i < ticks; ++i) {
    const Vec3 now_N = servo.step().force.contact;
    const Vec3 to = path(servo.tick() - 1);
    work_J += glm::dot((now_N + before_N) / 2.0, to - at);
    at = to;
    before_N = now_N;
  }
  return work_J;
}

/// Down at one place, along the surface to another one, up and back.
VirtualServo::Trajectory pressDragRelease(Vec3 from, Vec3 to) {
  return [=](std::uint64_t tick) {
    const double t = static_cast<double>(tick % 4000) / 1000;
    const Vec3 above(0, 0, 0.001), below(0, 0, -kDepth_m);
    if (t < 1) return glm::mix(from + above, from + below, t);
    if (t < 2) return glm::mix(from + below, to + below, t - 1);
    if (t < 3) return glm::mix(to + below, to + above, t - 2);
    return glm::mix(to + above, from + above, t - 3);
  };
}

/// About a place, 1 to 3 mm deep; seconds a loop: 2.
VirtualServo::Trajectory randomLoop(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi), size_m(0.002, 0.009);
  std::array<std::array<double, 2>, 6> wave{};
  for (auto& [amplitude_m, shift] : wave) {
    amplitude_m = size_m(random);
    shift = phase(random);
  }
  return [wave](std::uint64_t tick) {
    const double t = std::numbers::pi * 1e-3 * static_cast<double>(tick);
    const auto along = [&](std::size_t i) {
      return wave[i][0] * std::sin(t + wave[i][1]) + wave[i + 1][0] / 2 * std::sin(2 * t + wave[i + 1][1]);
    };
    const double in = std::min(1.0, static_cast<double>(tick) / 1000);
    return Vec3(along(0), along(2), 0.002 * (1 - in) - in * (0.002 + 0.001 * std::sin(2 * t + wave[4][1])));
  };
}

constexpr double kMax_J = 1e-5;
constexpr std::uint64_t kLoop = 4000;

TEST(VaryingSprings, GiveTheHandNoEnergyWhereItPressesOnASoftPlaceAndLetsGoOfAStiffOne) {
  const auto field = gratingField(0.04);
  for (const auto& [from, to] :
       {std::pair(Vec3(0.02, 0.0123, 0), Vec3(0, 0.0123, 0)), std::pair(Vec3(0, 0.0123, 0), Vec3(0.02, 0.02, 0))}) {
    const auto path = pressDragRelease(from, to);
    VirtualServo servo(path, kConfig, sceneOf(1, {blockWith({.stiffness = {field}})}));
    servo.run(1);
    EXPECT_NEAR(loop_J(servo, path, kLoop), 0, kMax_J);
  }
}

TEST(VaryingSprings, OfSoftBodiesGiveTheHandNoEnergyEither) {
  const auto field = gratingField(0.04);
  const Vec3 trough(0.02, 0.0123, 0), crest(0, 0.0123, 0);
  for (const Maps& maps : {Maps{}, Maps{.stiffness = {field}}, Maps{.softness = {field}}}) {
    for (const bool up : {false, true}) {
      const auto path = up ? pressDragRelease(trough, crest) : pressDragRelease(crest, trough);
      VirtualServo servo(path, kConfig, sceneOf(1, {blockWith(maps, kTissue_N_per_m)}));
      servo.run(1);
      EXPECT_LE(loop_J(servo, path, kLoop), kMax_J) << (maps.stiffness.field != nullptr) << up;
    }
  }
}

TEST(VaryingSprings, OfViscousAndPlasticTissueOnlyTakeEnergy) {
  const auto field = gratingField(0.04);
  const Vec3 trough(0.02, 0.0123, 0), crest(0, 0.0123, 0);
  for (const auto& [return_s, plastic] : {std::pair(0.3, 0.0), std::pair(0.0, 0.6), std::pair(0.3, 0.6)}) {
    for (const bool up : {false, true}) {
      const auto path = up ? pressDragRelease(trough, crest) : pressDragRelease(crest, trough);
      ServoObject block = blockWith({.stiffness = {field}, .softness = {field}}, kTissue_N_per_m);
      block.tissue =
          std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.03, 2), kTissue_N_per_m, return_s, plastic});
      VirtualServo servo(path, kConfig, sceneOf(1, {block}));
      servo.run(1);
      for (int loop = 0; loop < 3; ++loop) {
        EXPECT_LE(loop_J(servo, path, kLoop), kMax_J) << return_s << ' ' << plastic << ' ' << up << ' ' << loop;
      }
    }
  }
}

TEST(VaryingSprings, GiveTheHandNoEnergyOnRandomLoopsOverSmoothMaps) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const Maps maps{.stiffness = {smoothField(seed)}, .softness = {smoothField(seed + 100)}, .variation = 0.6};
    for (const double tissue_N_per_m : {0.0, kTissue_N_per_m}) {
      const auto path = randomLoop(seed);
      VirtualServo servo(path, kConfig, sceneOf(1, {blockWith(maps, tissue_N_per_m)}));
      servo.run(1200);
      EXPECT_LE(loop_J(servo, path, 2000), kMax_J) << seed << " on " << tissue_N_per_m;
    }
  }
}

/// A valley along y, one mesh.
TEST(VaryingSprings, OfAValleyGiveTheHandNoEnergy) {
  constexpr float kHalf_m = 0.05F, kHigh_m = 0.03F;
  static const auto valley = surfaceOf(TriMesh{{{-kHalf_m, -kHalf_m, kHigh_m},
                                                {0, -kHalf_m, 0},
                                                {kHalf_m, -kHalf_m, kHigh_m},
                                                {-kHalf_m, kHalf_m, kHigh_m},
                                                {0, kHalf_m, 0},
                                                {kHalf_m, kHalf_m, kHigh_m}},
                                               {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}}});
  ServoObject object = objectOf(1, valley, Vec3(0));
  object.damping_Ns_per_m = 0;
  SurfaceProperties properties;
  properties.stiffnessOver = SurfaceMap{0.8, FieldFamily{FourierFamily{}}};
  DetailFields fields;
  fields.stiffness.field = smoothField(4);
  // Down on one side, into the valley and along it, up on the other side, through the air back.
  const Vec3 way[] = {{-0.02, -0.015, 0.014},   {-0.02, -0.015, 0.009}, {0.0004, -0.01, -0.002},
                      {-0.0003, 0.014, -0.002}, {0.018, 0.02, 0.008},   {0.018, 0.02, 0.014},
                      {0.018, 0.02, 0.02},      {-0.02, -0.015, 0.02},  {-0.02, -0.015, 0.014}};
  const auto path = [&](std::uint64_t tick) {
    const std::size_t leg = std::min<std::size_t>(tick / 1000, std::size(way) - 2);
    return glm::mix(way[leg], way[leg + 1], std::min(1.0, static_cast<double>(tick - 1000 * leg) / 1000));
  };
  VirtualServo servo(path, kConfig, sceneOf(1, {with(object, properties, fields)}));
  servo.run(1);
  EXPECT_NEAR(loop_J(servo, path, 8000), 0, kMax_J);
}

/// Where the IHIP itself moves by jumps from triangle to triangle.
TEST(VaryingSprings, OfAShadedSphereGiveTheHandNoEnergy) {
  static const auto sphere = surfaceOf(makeSphere(0.05, 40).value());
  ServoObject object = objectOf(1, sphere, Vec3(0));
  object.damping_Ns_per_m = 0;
  for (const bool back : {false, true}) {
    SurfaceProperties properties = shading(std::numbers::pi);
    properties.stiffnessOver = SurfaceMap{0.8, FieldFamily{FourierFamily{}}};
    DetailFields fields;
    fields.stiffness.field = gratingField(0.04);
    const auto path = [&](std::uint64_t tick) {
      const double t = std::min(4.0, static_cast<double>(tick) / 1000);
      const auto at = [&](double angle, double r) {
        const double lean = back ? -0.4 - angle : angle;
        return r * Vec3(std::sin(lean), 0.013 * std::cos(lean), std::cos(lean));
      };
      if (t < 1) return at(-0.4, 0.051 - 0.004 * t);
      if (t < 2) return at(-0.4 + 0.4 * (t - 1), 0.047);
      if (t < 3) return at(0, 0.047 + 0.004 * (t - 2));
      return at(-0.4 * (t - 3), 0.051);
    };
    VirtualServo servo(path, kConfig, sceneOf(1, {with(object, properties, fields)}));
    servo.run(1);
    EXPECT_LE(loop_J(servo, path, 4000), kMax_J);
  }
}

/// Two leaning blocks, each softer in another way along the groove.
TEST(VaryingSprings, OfAGrooveOfTwoBodiesGiveTheHandNoEnergyAlongIt) {
  const auto wall = [](std::uint64_t id, double lean_rad, std::uint32_t seed, double tissue_N_per_m) {
    ServoObject block =
        blockWith({.stiffness = {smoothField(seed)}, .softness = {smoothField(seed + 7)}}, tissue_N_per_m);
    block.id = id;
    const Vec3 normal(std::sin(lean_rad), 0, std::cos(lean_rad));
    const Vec3 up = (lean_rad > 0 ? -1.0 : 1.0) * Vec3(std::cos(lean_rad), 0, -std::sin(lean_rad));
    block.pose = {Quat(std::cos(lean_rad / 2), 0, std::sin(lean_rad / 2), 0), 0.045 * up - 0.05 * normal};
    return block;
  };
  const auto path = pressDragRelease(Vec3(0, -0.012, 0), Vec3(0, 0.017, 0));
  for (const double tissue_N_per_m : {0.0, kTissue_N_per_m}) {
    VirtualServo servo(path, kConfig);
    const double half = std::numbers::pi / 4;
    servo.adopt(sceneOf(1, {wall(1, half, 4, tissue_N_per_m), wall(2, -half, 5, tissue_N_per_m)}));
    servo.run(1);
    EXPECT_LE(loop_J(servo, path, kLoop), kMax_J) << tissue_N_per_m;
  }
}

TEST(VaryingSprings, StayWithinTheLateralStiffnessThatTheDeviceBears) {
  StepConfig config = kConfig;
  config.stableLateral_N_per_m = 500;
  const auto field = gratingField(0.003);
  VirtualServo servo(downAt({0.00075, 0.0123, 0}), config, sceneOf(1, {blockWith({.stiffness = {field}})}));
  const double q = 2 * std::numbers::pi / 0.003;
  const double lateral = kStiffness * 0.8 * (q * q * kDepth_m * kDepth_m / 2 + q * kDepth_m);
  const double whole_N = kStiffness * 0.8 * q * kDepth_m * kDepth_m / 2;
  EXPECT_NEAR(servo.run(300).force.spring.x, whole_N * 500 / lateral, 0.02 * whole_N * 500 / lateral);
}

// ---- Edits ----

double largestStep_N(const ServoObject& before, const ServoObject& after) {
  VirtualServo servo(downAt({0.013, 0.0123, 0}, 0.002), kConfig, sceneOf(1, {before}));
  Vec3 last = servo.run(400).force.written;
  servo.adopt(sceneOf(2, {after}));
  double most_N = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 now = servo.step().force.written;
    most_N = std::max(most_N, glm::distance(now, last));
    last = now;
  }
  VirtualServo settled(downAt({0.013, 0.0123, 0}, 0.002), kConfig, sceneOf(1, {after}));
  EXPECT_NEAR(glm::distance(last, settled.run(400).force.written), 0, 1e-6);
  return most_N;
}

TEST(VaryingSprings, HaveNoStepWhereTheirMapIsEditedUnderTheStylus) {
  constexpr double kLetIn_N = EditSlew::kRate_N_per_s * 1e-3 + 1e-9;
  auto scale = std::make_shared<std::vector<float>>(makeBox(Vec3(0.1), 60).value().vertices.size(), 0.3F);
  for (const double tissue_N_per_m : {0.0, kTissue_N_per_m}) {
    const ServoObject plain = blockWith({}, tissue_N_per_m);
    const ServoObject one = blockWith({.stiffness = {smoothField(1)}, .softness = {smoothField(2)}}, tissue_N_per_m);
    const ServoObject other = blockWith({.stiffness = {smoothField(5)}}, tissue_N_per_m);
    const ServoObject values = blockWith({.stiffness = {nullptr, scale}}, tissue_N_per_m);
    ServoObject stiffer = one;
    stiffer.stiffness_N_per_m *= 1.5;
    stiffer.highestFactor = 0.8;
    for (const auto& [before, after] : {std::pair(plain, one), std::pair(one, plain), std::pair(one, other),
                                        std::pair(one, values), std::pair(values, plain), std::pair(one, stiffer)}) {
      EXPECT_LE(largestStep_N(before, after), kLetIn_N) << tissue_N_per_m;
    }
  }
}

TEST(VaryingSprings, NameTheJoulesThatAnEditOfTheStiffnessPutsIntoThem) {
  const auto field = gratingField(0.04);
  const ServoObject soft = blockWith({.stiffness = {field}});
  ServoObject stiff = soft;
  stiff.stiffness_N_per_m *= 2;
  const double factor = 1 + 0.8 * std::cos(2 * std::numbers::pi * 0.013 / 0.04);
  VirtualServo servo(downAt({0.013, 0.0123, 0}, 0.002), kConfig, sceneOf(1, {soft}));
  servo.run(400);
  servo.adopt(sceneOf(2, {stiff}));
  const TelemetrySample after = servo.run(400);
  EXPECT_NEAR(after.energyGiven_J[static_cast<std::size_t>(EnergyFeature::kEdit)],
              kStiffness * factor * 0.002 * 0.002 / 2, 1e-9);
}

TEST(VaryingSprings, AllocateNothing) {
  const Maps maps{.stiffness = {smoothField(1)}, .softness = {smoothField(2)}};
  VirtualServo servo(randomLoop(3), kConfig, sceneOf(1, {blockWith(maps, kTissue_N_per_m)}));
  servo.run(10);
  const std::uint64_t before = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    servo.run(2000);
  }
  EXPECT_EQ(AllocationTripwire::count(), before);
}

}  // namespace
}  // namespace haptics::varying_springs_tests
