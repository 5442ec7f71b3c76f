#include "haptic_server/scene/make_rigid_body.h"

#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "haptic_server/scene/derived_parts.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics::make_rigid_body_test {
namespace {

TriMesh openSphere() {
  TriMesh mesh = makeSphere(0.05, 4).value();
  mesh.triangles.pop_back();
  return mesh;
}

TEST(MakeRigidBody, FillsAClosedMeshEvenly) {
  const RigidBody body = rigidBodyFrom({.mass_kg = 0.3}, makeBox({0.06, 0.06, 0.06}, 1).value()).value();
  EXPECT_NEAR(body.mass.moments.x, 0.3 * 0.06 * 0.06 / 6, 1e-9);
}

TEST(MakeRigidBody, RefusesAnOpenMeshUnlessAnInertiaIsGiven) {
  MotionProperties motion{.mass_kg = 0.3};
  const auto refusal = rigidBodyFrom(motion, openSphere());
  ASSERT_FALSE(refusal);
  EXPECT_EQ(refusal.error().field, "inertia");
  EXPECT_NE(refusal.error().reason.find("open"), std::string::npos);
  motion.inertia = GivenInertia{{0, 0, 0.01}, {1e-4, 1e-4, 1e-4}, {}};
  EXPECT_EQ(rigidBodyFrom(motion, openSphere()).value().mass.centre, Vec3(0, 0, 0.01));
}

TEST(MakeRigidBody, RefusesAnInertiaThatNoBodyHas) {
  MotionProperties motion{.mass_kg = 0.3, .inertia = GivenInertia{{}, {1, 1, 3}, {}}};
  EXPECT_FALSE(rigidBodyFrom(motion, openSphere()));
  motion.inertia = GivenInertia{{}, {1, 1, 1}, {0, 0, 1.5}};
  EXPECT_FALSE(rigidBodyFrom(motion, openSphere()));
}

TEST(BodyParts, OfAnOpenMeshThatMovesDoNotCollide) {
  AssetStore store;
  ObjectRecord record;
  ObjectAssets assets;
  assets.mesh = store.intern(openSphere());
  const auto errorOf = [&](const MotionProperties& motion) {
    record.motion = motion;
    const auto parts = bodyPartsOf(record, assets);
    return *parts ? std::string() : parts->error().field;
  };
  MotionProperties moving{.mass_kg = 0.3, .inertia = GivenInertia{{}, {1e-4, 1e-4, 1e-4}, {}}};
  EXPECT_EQ(errorOf(moving), "");
  moving.collision = CollisionProperties{};
  EXPECT_EQ(errorOf(moving), "collision");
  EXPECT_EQ(errorOf({.fixed = true, .collision = CollisionProperties{}}), "") << "ground may be open";
  EXPECT_EQ(errorOf({.tool = ToolProperties{0.005}}), "") << "a tool may";
}

TEST(MotionWarnings, TellOfABodyThatIsTooLightForItsStiffness) {
  AssetStore store;
  ObjectRecord record;
  record.material.stiffness_N_per_m = 1000;
  record.material.damping_Ns_per_m = 0;
  record.motion = MotionProperties{.mass_kg = 0.1};
  ObjectAssets assets;
  assets.mesh = store.intern(makeBox(Vec3(0.02), 1).value());
  EXPECT_TRUE(motionWarnings(record, assets, {.period_s = 1e-3}).empty());
  record.motion->mass_kg = 0.002;
  const auto warnings = motionWarnings(record, assets, {.period_s = 1e-3});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("instead of 1000"), std::string::npos) << warnings[0];
  EXPECT_TRUE(motionWarnings(record, assets, {.period_s = 1e-4}).empty()) << "at a higher rate it bears more";
}

}  // namespace
}  // namespace haptics::make_rigid_body_test
