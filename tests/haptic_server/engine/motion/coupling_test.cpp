#include "haptic_server/engine/motion/coupling.h"

#include <gtest/gtest.h>

#include <random>

#include "bodies.h"

namespace haptics::test::coupling_test {
namespace {

TEST(FeltMass, OfASliderIsItsMassAndOfAHingeItsMomentOverTheSquaredArm) {
  const TriMesh mesh = makeBox({0.2, 0.02, 0.1}, 2).value();
  RigidBody body = bodyOf(mesh, 0.3);
  body.freedom = Freedom::kSlider;
  EXPECT_EQ(minApparentMass_kg(body, mesh.vertices), 0.3);
  body.freedom = Freedom::kHinge;
  body.joint = {{-0.1, 0, 0}, {0, 0, 1}};
  const double moment = 0.3 * (0.2 * 0.2 + 0.02 * 0.02) / 12 + 0.3 * 0.1 * 0.1;
  EXPECT_NEAR(minApparentMass_kg(body, mesh.vertices), moment / (0.2 * 0.2 + 0.01 * 0.01), 1e-6);
}

TEST(FeltMass, OfAFreeBodyIsTheLeastThatAnyPushFeels) {
  const TriMesh mesh = makeBox({0.2, 0.02, 0.1}, 2).value();
  const RigidBody body = bodyOf(mesh, 0.3);
  double least = 1e9;
  std::mt19937 random(1);
  std::normal_distribution<double> number;
  for (const Vec3f vertex : mesh.vertices) {
    const Vec3 arm = glm::conjugate(body.mass.principal) * (Vec3(vertex) - body.mass.centre);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 lever = glm::cross(arm, glm::normalize(Vec3(number(random), number(random), number(random))));
      least = std::min(least, 1 / (1 / 0.3 + glm::dot(lever, lever / body.mass.moments)));
    }
  }
  EXPECT_LE(minApparentMass_kg(body, mesh.vertices), least);
  EXPECT_NEAR(minApparentMass_kg(body, mesh.vertices), least, 0.01 * least);
}

/// Largest speed, in those of the stylus, at which a spring that a moving stylus brings lets a body go.
double thrown(double mass_kg, double stiffness, double damping) {
  constexpr double kSpeed = 0.05;
  double most = 0;
  for (int start = 0; start < 100; ++start) {
    double body = kSpeed * kPeriod_s * start / 100, speed = 0, deep = 0;
    bool met = false;
    for (int tick = 1; tick < 3000; ++tick) {
      const double depth = kSpeed * kPeriod_s * tick - body;
      const double force = depth > 0 ? stiffness * depth + damping * (depth - deep) / kPeriod_s : 0;
      deep = depth;
      speed += kPeriod_s * std::max(force, 0.0) / mass_kg;
      body += kPeriod_s * speed;
      if (met && depth <= 0) break;
      met = met || depth > 0;
    }
    most = std::max(most, speed / kSpeed);
  }
  return most;
}

TEST(BearableShare, LetsNoBodyBeThrownFasterThanAnElasticImpactDoes) {
  constexpr double kStiffness = 1000;
  for (const double damping : {0.0, 0.5, 2.0}) {
    for (const double mass_kg : {0.0001, 0.0005, 0.001, 0.002, 0.01, 0.1}) {
      const double share = stableStiffnessShare(mass_kg, kStiffness, damping, kPeriod_s);
      EXPECT_LE(thrown(mass_kg, share * kStiffness, share * damping), 2.07) << mass_kg << " kg " << damping;
    }
    EXPECT_GT(thrown(0.0001, kStiffness, damping), 4) << "what it is there for";
  }
  EXPECT_EQ(stableStiffnessShare(0.1, kStiffness, 0.5, kPeriod_s), 1);
}

}  // namespace
}  // namespace haptics::test::coupling_test
