#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/engine/step/soft_bodies.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::plastic_bodies_tests {
namespace {

using namespace fixture;

constexpr double kRadius_m = 0.05;
constexpr double kContact_N_per_m = 1000;
constexpr double kTissue_N_per_m = 300;
constexpr double kShare = kContact_N_per_m / (kContact_N_per_m + kTissue_N_per_m);
constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 1e9};

const TriMesh& sphere() {
  static const TriMesh mesh = makeSphere(kRadius_m, 48).value();
  return mesh;
}

SoftTissue clay(double plastic = 1, double radius_m = 0.012) {
  return {Falloff(radius_m, 2), kTissue_N_per_m, 0, plastic};
}

std::shared_ptr<const ServoScene> claySphere(const SoftTissue& tissue) {
  static const std::shared_ptr<const CollisionMesh> surface = surfaceOf(sphere());
  auto object = objectOf(1, surface, Vec3(0), kContact_N_per_m);
  object.damping_Ns_per_m = 0;
  object.tissue = std::make_shared<const SoftTissue>(tissue);
  object.baked.shape = 1;
  return sceneOf(1, {object});
}

/// The same with the dents that stay in its surface, as the builder makes it.
std::shared_ptr<const ServoScene> withDentsTaken(const ServoScene& scene, const HapticState& state) {
  auto next = std::make_shared<ServoScene>(scene);
  ++next->revision;
  ServoObject& object = next->objects.front();
  std::vector<Vec3f> vertices = sphere().vertices;
  for (const BodyDent& dent : state.allDents()) {
    if (!dent.stays) break;
    for (Vec3f& v : vertices) v = dented(v, {&dent.dent, 1}, object.tissue->falloff);
    object.baked.upTo = dent.number;
  }
  object.surface = refitCollisionMesh(*object.surface, vertices);
  return next;
}

Vec3 over(double angle, double height_m) { return (kRadius_m + height_m) * Vec3(std::sin(angle), 0, std::cos(angle)); }

/// Down to a depth in 0.2 s, up again in 0.2 s, then well above.
Vec3 pressed(std::uint64_t tick, double depth_m, double angle = 0) {
  const double t = double(tick) / 200;
  return over(angle, t < 2 ? 0.001 - (depth_m + 0.001) * (1 - std::abs(1 - t)) : 0.02);
}

double depthOf(const BodyDent& dent) { return glm::length(Vec3(dent.dent.displacement)); }

TEST(PlasticBody, KeepsItsPartOfTheDeepestDent) {
  for (const double plastic : {0.4, 1.0}) {
    VirtualServo servo([](std::uint64_t tick) { return pressed(tick, 0.003); }, kConfig, claySphere(clay(plastic)));
    double deepest = 0;
    for (int i = 0; i < 1200; ++i) {
      static_cast<void>(servo.step());
      for (const BodyDent& dent : servo.state().allDents()) deepest = std::max(deepest, depthOf(dent));
    }
    ASSERT_EQ(servo.state().dents.count, 1U);
    EXPECT_NEAR(deepest, kShare * 0.003, 3e-5);
    EXPECT_NEAR(depthOf(servo.state().dents[0]), plastic * deepest, 1e-6);
    EXPECT_TRUE(servo.state().dents[0].stays);
  }
}

TEST(PlasticBody, UnloadsByTheContactsSpringAloneAndIsLeftWhereItStays) {
  VirtualServo servo([](std::uint64_t tick) { return pressed(tick, 0.003); }, kConfig, claySphere(clay()));
  TelemetrySample sample = servo.run(201);
  const double most_N = sample.force.spring.z;
  EXPECT_NEAR(most_N, 0.003 / (1 / kContact_N_per_m + 1 / kTissue_N_per_m), 0.03);
  double lastHeight = 0;
  for (int i = 0; i < 200 && sample.object != 0; ++i) {
    const double up = 0.004 * (i + 1) / 200;
    sample = servo.step();
    if (sample.object == 0) break;
    EXPECT_NEAR(sample.force.spring.z, most_N - kContact_N_per_m * up, 0.05) << i;
    lastHeight = sample.hip.z;
  }
  EXPECT_NEAR(lastHeight, kRadius_m - kShare * 0.003, 1e-4);
}

TEST(PlasticBody, IsAtRestInItsNewShapeForTheNextContact) {
  const auto twice = [](std::uint64_t tick) { return pressed(tick % 1000, 0.003); };
  VirtualServo servo(twice, kConfig, claySphere(clay()));
  static_cast<void>(servo.run(1000));
  double surface = 0;
  TelemetrySample sample;
  for (int i = 0; i < 200; ++i) {
    sample = servo.step();
    if (sample.object != 0 && surface == 0) surface = sample.hip.z;
  }
  EXPECT_NEAR(surface, kRadius_m - kShare * 0.003, 1e-4);
  const double depth = surface - (kRadius_m - 0.003);
  EXPECT_NEAR(sample.force.spring.z, depth / (1 / kContact_N_per_m + 1 / kTissue_N_per_m), 0.03);
}

/// Two copies of a servo: the surface of one takes the dents in.
struct Twins {
  VirtualServo one, other;
  std::shared_ptr<const ServoScene> scene;

  Twins(const VirtualServo::Trajectory& hand, std::uint64_t ticks) : one(hand, kConfig), other(hand, kConfig) {
    scene = claySphere(clay());
    one.adopt(scene);
    static_cast<void>(one.run(ticks));
    other = one;
    EXPECT_TRUE(one.state().dents.count > 0 && one.state().dents[0].stays) << "the scene does not do what it is for";
    other.adopt(withDentsTaken(*scene, one.state()));
    EXPECT_TRUE(other.adopted());
  }

  /// How many of the ticks touch. Both twins feel the same in all of them, the first one to the last digit.
  int follow(int ticks, double tolerance_m = 1e-9) {
    int touching = 0;
    for (int i = 0; i < ticks; ++i) {
      const TelemetrySample a = one.step(), b = other.step();
      EXPECT_EQ(a.object, b.object) << "tick " << i;
      EXPECT_LT(glm::distance(a.ihip, b.ihip), i == 0 ? 1e-9 : tolerance_m) << "tick " << i;
      EXPECT_LT(glm::distance(a.force.written, b.force.written), kContact_N_per_m * tolerance_m) << "tick " << i;
      touching += a.object != 0;
      if (::testing::Test::HasFailure()) break;
    }
    return touching;
  }
};

TEST(PlasticBody, DoesNotJumpUnderAHandThatPressesIntoADentWhileTheSurfaceTakesItIn) {
  Twins twins(
      [](std::uint64_t tick) {
        if (tick < 1000) return pressed(tick, 0.003);
        const double t = double(tick - 1000) * 1e-3;
        return over(0.1 * std::sin(2 * t), 0.001 - 0.005 * std::min(1.0, 4 * t));
      },
      1500);
  EXPECT_EQ(twins.one.state().dents.count, 2U) << "that in which the hand is, and that which it left";
  EXPECT_EQ(twins.other.state().dents.count, 1U);
  EXPECT_EQ(twins.follow(1000), 1000);
}

TEST(PlasticBody, DoesNotJumpUnderAHandInTheHollowOrBesideItEither) {
  for (const double height_m : {-0.0015, 0.0005}) {  // in the hollow; above the surface as it was
    Twins twins(
        [&](std::uint64_t tick) {
          if (tick < 1000) return pressed(tick, 0.003);
          const double t = (double(tick) - 1500) * 1e-3;
          return over(t < 0 ? 0 : 0.3 * t, height_m);
        },
        1500);
    const int touching = twins.follow(1000, 1e-4);  // a slope may be met on a triangle beside
    EXPECT_EQ(touching > 0, height_m < 0);
  }
}

TEST(PlasticBody, DoesNotJumpUnderAHandThatPressesWhileADentBesideItIsReleased) {
  const auto hand = [](std::uint64_t tick) {
    return tick < 1000 ? pressed(tick, 0.003) : over(0.8, 0.001 - 0.004 * std::min(1.0, double(tick - 1000) / 200));
  };
  const std::shared_ptr<const ServoScene> scene = claySphere(clay());
  VirtualServo servo(hand, kConfig, scene);
  const TelemetrySample before = servo.run(1500);
  ASSERT_EQ(servo.state().dents.count, 2U);
  ASSERT_TRUE(servo.state().dents[0].stays);
  const auto released = std::make_shared<ServoScene>(*scene);
  ++released->revision;
  released->objects.front().baked.releasedUpTo = servo.state().dents[0].number;
  servo.adopt(released);
  for (int i = 0; i < 500; ++i) {
    EXPECT_NEAR(glm::distance(servo.step().force.written, before.force.written), 0, 0.02) << "tick " << i;
    if (HasFailure()) break;
  }
  EXPECT_FALSE(servo.state().dents[0].stays);
}

/// Depth of the dented sphere below the sphere, along the way of the hand.
double grooveAt(const HapticState& state, const SoftTissue& tissue, double angle) {
  std::vector<Dent> dents;
  for (const BodyDent& dent : state.allDents()) dents.push_back(dent.dent);
  return kRadius_m - glm::length(Vec3(dented(Vec3f(over(angle, 0)), dents, tissue.falloff)));
}

TEST(PlasticBody, IsLeftWithAGrooveByAHandThatSlides) {
  const SoftTissue tissue = clay(1, 0.008);
  constexpr double kDepth_m = 0.002, kTo = 0.6;
  const auto slide = [&](std::uint64_t tick) {
    const double t = double(tick) * 1e-3;
    const double down = std::min(1.0, 10 * t), up = std::clamp(10 * (t - 1.6), 0.0, 1.0);
    return over(kTo * std::clamp((t - 0.2) / 1.2, 0.0, 1.0), 0.001 - (kDepth_m + 0.001) * down + 0.005 * up);
  };
  VirtualServo servo(slide, kConfig, claySphere(tissue));
  double least_N = 1e9, most_N = 0;
  for (int i = 0; i < 3000; ++i) {
    const double force = glm::length(servo.step().force.contact);
    if (i > 250 && i < 1350) {
      least_N = std::min(least_N, force);
      most_N = std::max(most_N, force);
    }
  }
  const double expected_N = kDepth_m / (1 / kContact_N_per_m + 1 / kTissue_N_per_m);
  EXPECT_GT(least_N, 0.85 * expected_N) << "marks are not felt by the hand that leaves them";
  EXPECT_LT(most_N, 1.15 * expected_N);
  EXPECT_GT(servo.state().dents.count, 2U);
  double shallowest = 1, deepest = 0;
  for (double angle = 0; angle <= kTo; angle += 0.01) {
    const double depth = grooveAt(servo.state(), tissue, angle);
    shallowest = std::min(shallowest, depth);
    deepest = std::max(deepest, depth);
  }
  EXPECT_GT(shallowest, 0.6 * kShare * kDepth_m);
  EXPECT_LT(deepest, 1.4 * kShare * kDepth_m);
}

TEST(PlasticBody, GivesTheHandNoEnergy) {
  for (const double plastic : {0.3, 1.0}) {
    const auto hip = [](std::uint64_t tick) {
      const double angle = 2e-3 * double(tick);
      return (kRadius_m + 0.002 - 0.005 * std::abs(std::sin(0.01 * double(tick)))) *
             Vec3(std::sin(angle), 0.1, std::cos(angle)) / std::sqrt(1.01);
    };
    VirtualServo servo(hip, kConfig, claySphere(clay(plastic)));
    double work_J = 0, most_J = 0;
    Vec3 lastHip = hip(0), lastForce(0);
    for (std::uint64_t tick = 0; tick < 3142; ++tick) {
      const TelemetrySample sample = servo.step();
      work_J += glm::dot(0.5 * (lastForce + sample.force.contact), hip(tick) - lastHip);
      most_J = std::max(most_J, work_J);
      lastHip = hip(tick);
      lastForce = sample.force.contact;
    }
    // Ten presses, each of which stores 1 mJ; the dent's own facets turn the force by a little.
    EXPECT_LT(most_J, 5e-3 * 10e-3);
    EXPECT_LT(work_J, -2e-4) << "denting takes work";
  }
}

TEST(PlasticBody, LetsADentGoBackSlowlyThatMayNotStay) {
  VirtualServo servo([](std::uint64_t tick) { return pressed(tick, 0.003); }, kConfig);
  const auto scene = claySphere(clay());
  servo.adopt(scene);
  static_cast<void>(servo.run(1000));
  ASSERT_EQ(servo.state().dents.count, 1U);
  auto loosened = std::make_shared<ServoScene>(*scene);
  loosened->objects[0].baked.releasedUpTo = servo.state().dents[0].number;
  servo.adopt(loosened);
  double last = depthOf(servo.state().dents[0]);
  static_cast<void>(servo.step());
  ASSERT_EQ(servo.state().dents.count, 1U);
  EXPECT_GT(depthOf(servo.state().dents[0]), 0.9 * last);
  static_cast<void>(servo.run(500));
  EXPECT_EQ(servo.state().dents.count, 0U);
}

}  // namespace
}  // namespace haptics::plastic_bodies_tests
