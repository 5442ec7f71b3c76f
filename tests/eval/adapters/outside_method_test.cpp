// Methods from outside: the examples beside the built-in penalty method, and what becomes of those that misbehave.
#include "tests/eval/adapters/outside_method.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/eval/random.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::outside_method_test {
namespace {

std::string libraryOf(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "methods" / (name + ".so");
}

const std::string& penaltyInPython() {
  static const std::string command =
      "/usr/bin/python3 -B " + (std::filesystem::path(__FILE__).parent_path() / "penalty.py").string();
  return command;
}

/// Three bodies, each with a pose of its own.
struct Bodies {
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces{shapes::sphere(0.03, 12).build(),
                                                             shapes::torus(0.03, 0.01, 24, 12).build(),
                                                             shapes::box({0.02, 0.03, 0.01}, 3).build()};
  std::vector<Pose> poses;

  explicit Bodies(Random& random) {
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      poses.push_back({random.rotation(), Vec3(0.03 * static_cast<double>(i), 0, 0)});
    }
  }
};

/// Is the hand in a body whose nearest place is on an edge? Two triangles hold that, each with a rounding of its own, and both
/// may be equally near.
bool isPushedOutOverAnEdge(const Bodies& bodies, Vec3 hip) {
  for (std::size_t i = 0; i < bodies.surfaces.size(); ++i) {
    const CollisionMesh& surface = *bodies.surfaces[i];
    const Vec3 local = toLocal(bodies.poses[i], hip);
    int looked = 0;
    const ClosestPoint foot = surface.closestFoot(local, 1 << 20, looked);
    if (!surface.isOutside(foot, local) && foot.feature == Feature::kLine) return true;
  }
  return false;
}

TEST(OutsideMethod, PenaltyInCGivesTheForcesOfTheBuiltInOneBitForBit) {
  Random random(1);
  Bodies bodies(random);
  const auto ours = findMethod("global_closest", methods()).make();
  const auto theirs = findMethod(libraryOf("penalty"), methods()).make();
  const Vec3 start(0, 0, 1);
  ours->begin(bodies.surfaces, bodies.poses, start);
  theirs->begin(bodies.surfaces, bodies.poses, start);
  int touching = 0;
  for (int i = 0; i < 5000; ++i) {
    bodies.poses[1] = {random.rotation(), random.direction() * 0.02};
    const Vec3 hip = random.direction() * random.between(0, 0.06) + Vec3(0.03, 0, 0);
    const Felt a = ours->tick(bodies.poses, hip);
    const Felt b = theirs->tick(bodies.poses, hip);
    ASSERT_EQ(a.touching, b.touching) << i;
    if (isPushedOutOverAnEdge(bodies, hip)) {
      ASSERT_NEAR(glm::distance(a.force_N, b.force_N), 0, 1e-12) << i;
    } else {
      ASSERT_EQ(a.force_N, b.force_N) << i;
      ASSERT_EQ(a.ihip, b.ihip) << i;
      touching += a.touching ? 1 : 0;
    }
  }
  EXPECT_GT(touching, 500);
}

TEST(OutsideMethod, PenaltyInPythonGivesThemToRounding) {
  Random random(2);
  const Bodies bodies(random);
  const auto ours = findMethod("global_closest", methods()).make();
  const auto theirs = findMethod(penaltyInPython(), methods()).make();
  ours->begin(bodies.surfaces, bodies.poses, Vec3(0, 0, 1));
  theirs->begin(bodies.surfaces, bodies.poses, Vec3(0, 0, 1));
  int touching = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 hip = random.direction() * random.between(0, 0.06) + Vec3(0.03, 0, 0);
    const Felt a = ours->tick(bodies.poses, hip);
    const Felt b = theirs->tick(bodies.poses, hip);
    ASSERT_EQ(a.touching, b.touching) << i;
    ASSERT_NEAR(glm::distance(a.force_N, b.force_N), 0, 1e-9) << i;
    touching += a.touching ? 1 : 0;
  }
  EXPECT_GT(touching, 100);
}

class Penalty : public testing::TestWithParam<bool> {};

TEST_P(Penalty, HoldsAHandWithinARoom) {
  shapes::Shape walls = shapes::box({0.1, 0.06, 0.08});
  for (auto& triangle : walls.triangles) std::swap(triangle[1], triangle[2]);
  const std::vector<std::shared_ptr<const CollisionMesh>> room{walls.build()};
  const std::vector<Pose> poses{{Random(6).rotation(), Vec3(0.2, 0, 0)}};
  const auto method = findMethod(GetParam() ? penaltyInPython() : libraryOf("penalty"), methods()).make();
  const auto feltAt = [&](Vec3 local) { return method->tick(poses, toWorld(poses[0], local)); };
  method->begin(room, poses, poses[0].position);
  EXPECT_FALSE(feltAt(Vec3(0.049, 0, 0.01)).touching);
  for (const double beyond_m : {0.0505, 0.2}) {
    const Felt felt = feltAt(Vec3(beyond_m, 0, 0.01));
    EXPECT_TRUE(felt.touching) << beyond_m;
    EXPECT_NEAR(glm::distance(felt.ihip, toWorld(poses[0], Vec3(0.05, 0, 0.01))), 0, 1e-8) << beyond_m;
  }
}

INSTANTIATE_TEST_SUITE_P(OfExamples, Penalty, testing::Bool(),
                         [](const auto& of) { return std::string(of.param ? "Python" : "C"); });

TEST(OutsideMethod, SaysHowManyTrianglesItLookedAtAndHowLongItTook) {
  Random random(3);
  const Bodies bodies(random);
  const auto method = findMethod(libraryOf("penalty"), methods()).make();
  method->begin(bodies.surfaces, bodies.poses, Vec3(0, 0, 1));
  std::uint32_t triangles = 0;
  for (const auto& surface : bodies.surfaces) triangles += surface->triangleCount();
  EXPECT_EQ(method->tick(bodies.poses, Vec3(0, 0, 1)).triangles, static_cast<int>(triangles));
  EXPECT_GT(ownTime_ns(*method).value(), 0);
}

std::string faultOf(const char* fault) {
  setenv("HAPTICS_FAULT", fault, 1);
  Random random(4);
  const Bodies bodies(random);
  try {
    const auto method = findMethod(libraryOf("faulty"), methods()).make();
    method->begin(bodies.surfaces, bodies.poses, Vec3(0, 0, 1));
    for (int i = 0; i < 200; ++i) (void)method->tick(bodies.poses, Vec3(0, 0, 1));
  } catch (const MethodFault& why) {
    return why.what();
  }
  return "nothing";
}

class Faults : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Faults, AreNamedWithTheirTick) {
  const std::string said = faultOf(GetParam().first);
  EXPECT_NE(said.find(GetParam().second), std::string::npos) << said;
}

// Not of builds with sanitizers, which end a process otherwise.
INSTANTIATE_TEST_SUITE_P(OfMethods, Faults,
                         testing::Values(std::pair("none", "nothing"),
                                         std::pair("crash", "signal 6 (Aborted) in tick 100"),
                                         std::pair("exit", "exit status 7 in tick 100"),
                                         std::pair("hang", "in time in tick 100"),
                                         std::pair("nan_force", "force that is not finite in tick 100"),
                                         std::pair("nan_ihip", "IHIP that is not finite in tick 100"),
                                         std::pair("lie", "does not touch, and gives a force in tick 100"),
                                         std::pair("refuse", "refuses when a scene is loaded: of a bad mood")),
                         [](const auto& of) { return std::string(of.param.first); });

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
INSTANTIATE_TEST_SUITE_P(OfMemory, Faults,
                         testing::Values(std::pair("overrun", "signal 11 (Segmentation fault) in tick 100"),
                                         std::pair("spoil", "signal 11 (Segmentation fault) in tick 100"),
                                         std::pair("allocate", "signal 11 (Segmentation fault) in tick 100")),
                         [](const auto& of) { return std::string(of.param.first); });
#endif

std::string refusalOf(const std::string& command) {
  try {
    (void)findMethod(command, methods());
  } catch (const std::invalid_argument& why) {
    return why.what();
  }
  return "nothing";
}

TEST(OutsideMethod, IsRefusedWithAReasonWhenItIsNone) {
  EXPECT_NE(refusalOf("./hearsay.so").find("exit status 2"), std::string::npos) << refusalOf("./hearsay.so");
  EXPECT_NE(refusalOf("/hearsay/method").find("exit status 127"), std::string::npos);
  EXPECT_NE(refusalOf("sh -c 'echo hearsay hearsay; cat'").find("no message"), std::string::npos);
  EXPECT_NE(refusalOf("cat").find("there is none called cat"), std::string::npos);
}

TEST(OutsideMethod, IsNotPutUnderWhatItDoesNotDeclare) {
  setenv("HAPTICS_FAULT", "none", 1);
  Random random(5);
  Bodies bodies(random);
  const auto method = findMethod(libraryOf("faulty"), methods()).make();
  const auto sheet = shapes::box({0.02, 0.03, 0.01}, 3);
  shapes::Shape open = sheet;
  open.triangles.pop_back();
  const std::vector<std::shared_ptr<const CollisionMesh>> surfaces{open.build()};
  EXPECT_THROW(method->begin(surfaces, std::vector<Pose>(1), Vec3(0, 0, 1)), NotApplicable);
  EXPECT_THROW(method->edit({{}, bodies.surfaces, bodies.poses, 1000}, Vec3(0, 0, 1)), NotApplicable);
  EXPECT_NO_THROW(method->begin(bodies.surfaces, bodies.poses, Vec3(0, 0, 1)));
}

}  // namespace
}  // namespace haptics::eval::outside_method_test
