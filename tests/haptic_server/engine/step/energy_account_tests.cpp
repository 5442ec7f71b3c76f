#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::energy_account_tests {
namespace {

EnergyState told(const VirtualServo& servo) {
  EnergyState state;
  servo.state().energy.copyTo(state);
  return state;
}

double of(const VirtualServo& servo, EnergyFeature feature) {
  return servo.state().energy.all_J()[static_cast<std::size_t>(feature)];
}

double sum(const EnergyByFeature& given_J) { return std::accumulate(given_J.begin(), given_J.end(), 0.0); }

/// Who gives most, in the end.
EnergySource culprit(const VirtualServo& servo) { return largestSource(told(servo)).value_or(EnergySource{}); }

/// Runs the servo and adds up what the force as written does along the way.
double workOf(VirtualServo& servo, const VirtualServo::Trajectory& way, int ticks) {
  double work_J = 0;
  Vec3 written(0);
  Vec3 before = way(servo.tick());
  for (int i = 0; i < ticks; ++i) {
    const Vec3 now = way(servo.tick());
    work_J += glm::dot(written, now - before);
    before = now;
    written = servo.step().force.written;
  }
  return work_J;
}

double ramp(std::uint64_t tick, std::uint64_t from, std::uint64_t to) {
  return std::clamp((static_cast<double>(tick) - static_cast<double>(from)) / static_cast<double>(to - from), 0.0, 1.0);
}

/// Down to a depth on the slab within 200 ticks, up again from tick 1000 to 1200.
VirtualServo::Trajectory pressAndLift(double depth_m) {
  return [=](std::uint64_t tick) {
    return Vec3(0.001, 0.0123, 0.003 - (0.003 + depth_m) * (ramp(tick, 0, 200) - ramp(tick, 1000, 1200)));
  };
}

ServoObject undamped(ServoObject object) {
  object.damping_Ns_per_m = 0;
  return object;
}

TEST(EnergyAccount, OfAllSourcesIsTheWorkOfTheForceAsWritten) {
  SurfaceProperties properties = friction(0.6, 0.4);
  properties.shading = shading(0.6).shading;
  const auto way = strokeAlongX(0.002, 0.02);
  StepConfig config = kConfig;
  config.maxForce_N = 1.3;  // reached
  VirtualServo servo(way, config, sceneOf(1, {withGrating(slab(), 0.003, 0.0002, 1.5, properties)}));
  double work_J = workOf(servo, way, 600);
  ServoObject softer = withGrating(slab(), 0.004, 0.0003, 1.5, properties);
  softer.stiffness_N_per_m /= 2;
  EnergyByFeature between = servo.state().energy.all_J();
  EXPECT_NEAR(sum(between), work_J, 1e-12);
  servo.adopt(sceneOf(2, {softer}));
  double more_J = workOf(servo, way, 600);
  // The way from the last tick of one run to the first of the other is not in either.
  const EnergyByFeature all = servo.state().energy.all_J();
  EXPECT_NEAR(sum(all) - sum(between), more_J, 1e-4);
  EXPECT_NE(of(servo, EnergyFeature::kFriction), 0);
  EXPECT_NE(of(servo, EnergyFeature::kTexture), 0);
  EXPECT_NE(of(servo, EnergyFeature::kEdit), 0);
  ASSERT_EQ(told(servo).objectCount, 1U);
  EXPECT_EQ(told(servo).object[0].given_J, all);
}

TEST(EnergyAccount, NamesAnEditThatStiffensWhatIsPressed) {
  VirtualServo servo(pressAndLift(0.002), kConfig, sceneOf(1, {undamped(slab())}));
  servo.run(500);
  EXPECT_EQ(of(servo, EnergyFeature::kEdit), 0);
  ServoObject stiffer = undamped(slab());
  stiffer.stiffness_N_per_m *= 2;
  servo.adopt(sceneOf(2, {stiffer}));
  servo.run(400);
  const double put_J = kStiffness / 2 * 0.002 * 0.002;
  EXPECT_NEAR(of(servo, EnergyFeature::kEdit), put_J, 0.01 * put_J);
  servo.run(500);
  EXPECT_NEAR(sum(servo.state().energy.all_J()), put_J, 0.05 * put_J) << "the hand has it";
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kEdit);
  EXPECT_EQ(culprit(servo).object, 1U);
}

TEST(EnergyAccount, NamesAnEditThatMovesAWallIntoTheHand) {
  VirtualServo servo(pressAndLift(0.001), kConfig, sceneOf(1, {undamped(slab(7))}));
  servo.run(500);
  servo.adopt(sceneOf(2, {undamped(slab(7, Vec3(0, 0, -0.049)))}));
  servo.run(400);
  // From 1 to 2 mm below: k (2^2 - 1^2) / 2.
  const double put_J = 1.5 * kStiffness * 1e-6;
  EXPECT_NEAR(of(servo, EnergyFeature::kEdit), put_J, 0.03 * put_J);
  servo.run(500);
  EXPECT_NEAR(sum(servo.state().energy.all_J()), put_J, 0.05 * put_J);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kEdit);
  EXPECT_EQ(culprit(servo).object, 7U);
}

TEST(EnergyAccount, NamesAnObjectThatIsPutAroundTheStylus) {
  VirtualServo servo(pressAndLift(0.002), kConfig);
  servo.run(500);
  servo.adopt(sceneOf(1, {undamped(slab(3))}));
  servo.run(900);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kEdit);
  EXPECT_EQ(culprit(servo).object, 3U);
}

TEST(EnergyAccount, NamesABodyThatPushesTheHandBack) {
  const TriMesh mesh = makeBox(Vec3(0.06), 2).value();
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  ASSERT_EQ(spreadMass(0.2, solid.centre, 0.2 / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  body.freedom = Freedom::kSlider;
  body.joint.axis = Vec3(0, 0, 1);
  body.joint.highest = 0.02;
  body.gravity_m_per_s2 = Vec3(0, 0, 5);  // upwards: 1 N
  ServoObject driven = objectOf(5, surfaceOf(mesh), Vec3(0, 0, -0.03));
  driven.motion = std::make_shared<RigidBody>(body);
  // The hand gives way upwards by 15 mm, slower than the body would be, then lifts off.
  const auto way = [](std::uint64_t tick) {
    return Vec3(0.001, 0.002, 0.0002 + 0.015 * ramp(tick, 100, 1100) + 0.03 * ramp(tick, 1100, 1400));
  };
  VirtualServo servo(way, kConfig, sceneOf(1, {driven}));
  servo.run(1500);
  EXPECT_NEAR(of(servo, EnergyFeature::kMotion), 0.2 * 5 * 0.015, 0.2 * 0.2 * 5 * 0.015);
  EXPECT_GT(sum(servo.state().energy.all_J()), 0.01);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kMotion);
  EXPECT_EQ(culprit(servo).object, 5U);
}

TEST(EnergyAccount, NamesATextureThatGivesMoreThanItTook) {
  // Eq. (4a) is not conservative: into a valley, along to a crest, and out (texture_law.h).
  constexpr double kWave_m = 0.004;
  const auto way = [](std::uint64_t tick) {
    const double x = 0.5 * kWave_m + 0.5 * kWave_m * ramp(tick, 300, 800);
    return Vec3(x, 0.0123, 0.003 - 0.005 * (ramp(tick, 0, 200) - ramp(tick, 900, 1100)));
  };
  VirtualServo servo(way, kConfig, sceneOf(1, {undamped(withGrating(slab(4), kWave_m, 0.0003))}));
  servo.run(1200);
  EXPECT_GT(sum(servo.state().energy.all_J()), 1e-5);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kTexture);
  EXPECT_EQ(culprit(servo).object, 4U);
}

TEST(EnergyAccount, NamesFrictionThatIsShakenBetweenTicks) {
  // A spring that is held from tick to tick gives energy to a hand that goes to and fro between two ticks' places.
  const auto way = [](std::uint64_t tick) {
    const double aside = tick > 300 && tick < 2000 && tick % 2 == 0 ? 0.0002 : 0;
    return Vec3(aside, 0.0123, 0.003 - 0.005 * (ramp(tick, 0, 200) - ramp(tick, 2100, 2300)));
  };
  VirtualServo servo(way, kConfig, sceneOf(1, {undamped(with(slab(6), friction(0.8, 0.8)))}));
  servo.run(2400);
  EXPECT_GT(sum(servo.state().energy.all_J()), 1e-3);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kFriction);
  EXPECT_EQ(culprit(servo).object, 6U);
}

TEST(EnergyAccount, NamesTheContactThatIsHeldFromTickToTick) {
  const auto way = [](std::uint64_t tick) { return Vec3(0.001, 0.0123, tick % 2 == 0 ? 0.0005 : -0.0005); };
  VirtualServo servo(way, kConfig, sceneOf(1, {undamped(slab(2))}));
  servo.run(200);
  EXPECT_GT(of(servo, EnergyFeature::kContact), 0.03);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kContact);
  EXPECT_EQ(culprit(servo).object, 2U);
}

TEST(EnergyAccount, NamesShadingThatTurnsTheForceAlongTheWay) {
  // From the middle of a facet towards its edge the shaded normal leans the way that the hand goes. Shading comes when the
  // hand is there already: what it took on the way in is what it gives on the way to the edge.
  constexpr double kRadius_m = 0.05;
  constexpr int kFacets = 12;
  const auto prism = surfaceOf(makeCylinder(kRadius_m, 0.1, kFacets).value());
  ServoObject object = objectOf(8, prism, Vec3(0), kStiffness);
  object.damping_Ns_per_m = 0;
  const double angle = std::numbers::pi / kFacets;
  const Vec3 out(std::cos(angle), std::sin(angle), 0);
  const Vec3 along(-out.y, out.x, 0);
  const auto way = [=](std::uint64_t tick) {
    return out * (0.06 - 0.013 * ramp(tick, 0, 200)) + along * (0.008 * ramp(tick, 300, 800)) + Vec3(0, 0, 0.001);
  };
  VirtualServo servo(way, kConfig, sceneOf(1, {object}));
  servo.run(250);
  servo.adopt(sceneOf(2, {with(object, shading(1.2))}));
  servo.run(550);
  EXPECT_GT(of(servo, EnergyFeature::kShading), 1e-4);
  EXPECT_EQ(culprit(servo).feature, EnergyFeature::kShading);
  EXPECT_EQ(culprit(servo).object, 8U);
}

TEST(EnergyAccount, KeepsTheTotalsAndTheWorstOfMoreObjectsThanItHasPlacesFor) {
  EnergyAccount account;
  account.begin(Vec3(0));
  Vec3 hip(0);
  double total_J = 0;
  for (std::uint64_t object = 1; object <= 40; ++object) {
    account.setHeldForce(object, Vec3(0, 0, 1));
    const double way_m = object == 7 ? 0.5 : 1e-3 * static_cast<double>(object % 5) - 2e-3;
    hip.z += way_m;
    total_J += way_m;
    account.integrate(hip);
  }
  EXPECT_NEAR(sum(account.all_J()), total_J, 1e-12);
  EnergyState state;
  account.copyTo(state);
  EXPECT_EQ(state.objectCount, EnergyState::kMax);
  ASSERT_TRUE(largestSource(state));
  EXPECT_EQ(largestSource(state)->object, 7U);
  EXPECT_NEAR(largestSource(state)->given_J, 0.5, 1e-12);
  EXPECT_TRUE(std::ranges::any_of(state.objects(), [](const ObjectEnergy& o) { return o.object == 40; })) << "the last";
}

}  // namespace
}  // namespace haptics::fixture::energy_account_tests
