#include "graphics_client/mirror/contact_error.h"

#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics::contact_error_test {
namespace {

std::optional<double> errorOf(ContactError& error, const MirrorView& view) {
  return view.sample ? error.of_m(view, *view.sample) : std::nullopt;
}

constexpr double kRadius_m = 0.05;
const Softness kSoft{.stiffness_N_per_m = 200, .radius_m = 0.02};

/// A soft ball that is touched, and a dent under the contact.
struct Touched : testing::Test {
  FakeMirror mirror;
  const TriMesh mesh = makeSphere(kRadius_m, 12).value();
  const ObjectId ball = mirror.add("ball", mesh, Pose{glm::angleAxis(0.7, Vec3(0, 1, 0)), {0.1, 0, 0.2}}, {});
  ContactError error;

  Touched() {
    mirror.setSoftness(ball, kSoft);
    mirror.touch(ball, 40, 0.004);
  }
  [[nodiscard]] TelemetrySample& sample() { return *mirror.view().sample; }
  [[nodiscard]] const ObjectRecord& record() { return *mirror.view().scene->find(ball); }
  void dent(Vec3 centre, Vec3 displacement) {
    mirror.view().dents.push_back({ball, {Vec3f(centre), Vec3f(displacement)}});
  }
};

TEST_F(Touched, IsNothingWhereTheIhipIsOnTheDentedTriangle) {
  EXPECT_NEAR(errorOf(error, mirror.view()).value(), 0, 1e-8);
  const Vec3 at = toLocal(record().pose, sample().ihip);
  dent(at, at * -0.08);
  EXPECT_NEAR(errorOf(error, mirror.view()).value(), 0.0038, 3e-4) << "the surface has gone away from under it";
  const auto corners = mirror.view().cornersOf(record(), 40).value();
  sample().ihip = toWorld(record().pose, (corners[0] + corners[1] + corners[2]) / 3.0);
  EXPECT_NEAR(errorOf(error, mirror.view()).value(), 0, 1e-8);
}

TEST_F(Touched, IsOfTheNearestTriangleWhicheverIsNamed) {
  const double onIt = errorOf(error, mirror.view()).value();
  for (std::uint32_t named = 0; named < mesh.triangles.size(); named += 7) {
    sample().primitive.polygon = named;
    EXPECT_EQ(errorOf(error, mirror.view()).value(), onIt) << named;
  }
}

TEST_F(Touched, CountsFromTheTextureTop) {
  sample().height_m = 0.001;
  sample().ihip += 0.001 * sample().surfaceNormal;
  EXPECT_NEAR(errorOf(error, mirror.view()).value(), 0, 1e-6);
}

TEST_F(Touched, IsOfWhatMovesOrGivesOnly) {
  const ObjectId wall = mirror.add("wall", mesh, {}, {});
  mirror.touch(wall, 3, 0.001);
  EXPECT_FALSE(errorOf(error, mirror.view()));
  mirror.view().sample.reset();
  EXPECT_FALSE(errorOf(error, mirror.view()));
}

TEST_F(Touched, IsUnknownWithoutTheMeshOrForATriangleThatItDoesNotHave) {
  sample().primitive.polygon = static_cast<std::uint32_t>(mesh.triangles.size());
  EXPECT_FALSE(errorOf(error, mirror.view()));
  sample().primitive.polygon = 0;
  mirror.view().meshes.clear();
  EXPECT_FALSE(errorOf(error, mirror.view()));
}

}  // namespace
}  // namespace haptics::contact_error_test
