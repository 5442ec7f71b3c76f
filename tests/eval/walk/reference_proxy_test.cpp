#include "tests/eval/walk/reference_proxy.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/eval/random.h"
#include "tests/eval/walk/cracked_block.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::reference_proxy_test {
namespace {

TEST(ReferenceProxy, GoesOnFromTheTipOfACrackOutsideOfTheBody) {
  const CrackedBlock block;
  const Vec3 tip(Vec3f(CrackedBlock::kTip));
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 hip = tip + Vec3(0, 0, -0.006) + random.direction() * 0.004;
    ReferenceProxy reference(block.soup);
    reference.resume(tip + random.direction() * 1e-12, hip);
    EXPECT_LT(glm::distance(reference.ihip(), tip), 1e-6) << "HIP at " << hip.x << ' ' << hip.y << ' ' << hip.z;
  }
}

TEST(ReferenceProxy, LeapsOnlyWhereAMinimumEnds) {
  const shapes::Shape cube = shapes::box({0.1, 0.1, 0.1});
  TriangleSoup soup;
  soup.add(cube.vertices, cube.triangles, Pose{});
  soup.finish();
  ReferenceProxy reference(soup);
  reference.place({0, 0, 0.06});
  reference.follow({0, 0, 0.03}, 64);
  EXPECT_LT(reference.leap_m(), 1e-9);
  reference.follow({0.025, 0, 0.03}, 64);
  EXPECT_LT(reference.leap_m(), 1e-9);
  reference.follow({0.06, 0, 0.03}, 64);  // over the edge, from where the side leads to the HIP
  EXPECT_NEAR(reference.leap_m(), 0.02, 1e-3);
}

TEST(ReferenceProxy, KeepsToAMinimumToItsSkinFromWhereThatEnds) {
  const shapes::Shape cube = shapes::box({0.1, 0.1, 0.1});
  const double side = 0.05F;
  Random random(1);
  for (const double before_m : {1e-11, 3e-11, 1e-10, 3e-10}) {
    const Pose pose{random.rotation(), random.direction() * 0.02};
    TriangleSoup soup;
    soup.add(cube.vertices, cube.triangles, pose);
    soup.finish();
    ReferenceProxy reference(soup);
    reference.place(toWorld(pose, {0.04, 0.01, 0.06}));
    reference.follow(toWorld(pose, {0.04, 0.01, 0.03}), 64);
    reference.follow(toWorld(pose, {side - before_m, 0.01, 0.03}), 64);
    EXPECT_LT(glm::distance(reference.ihip(), toWorld(pose, {side - before_m, 0.01, side})), 1e-9) << before_m;
    reference.follow(toWorld(pose, {side + before_m, 0.01, 0.03}), 64);
    EXPECT_GT(reference.leap_m(), 0.01) << before_m;
  }
}

/// The edge of a tetrahedron ends in the groove of two blocks, exactly. It juts out between them, so that from the place
/// where it does there is a way over each of its faces.
class EdgeInAGroove : public testing::Test {
 protected:
  static constexpr double kBeyond_m = 1e-4;
  TriangleSoup soup_;
  std::array<Vec3, 2> face_;  // outward, unit

  EdgeInAGroove() {
    const shapes::Shape block = shapes::box({0.25, 0.25, 0.25});
    for (const Vec3 centre : {Vec3(0, 0, -0.125), Vec3(0.125, 0, 0)}) {
      soup_.add(block.vertices, block.triangles, {{1, 0, 0, 0}, centre});
    }
    const Vec3f along(0x1p-8F, 0x1.18p-9F, -0x1p-8F);
    const std::vector<Vec3f> corner{
        3.0F * along, -2.0F * along, {0.018F, -0.0018F, 0.0095F}, {-0.0142F, 0.007F, -0.0123F}};
    const std::vector<TriangleIndices> triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    soup_.add(corner, triangles, Pose{});
    soup_.finish();
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 a(corner[triangles[i][0]]);
      face_[i] = glm::normalize(glm::cross(Vec3(corner[triangles[i][1]]) - a, Vec3(corner[triangles[i][2]]) - a));
    }
  }

  /// From where the edge ends to a HIP that presses against a block and a face, and is a little farther along both.
  void expectsAWay(Vec3 block, Vec3 face, Vec3 away) {
    const Vec3 line = glm::cross(block, face);
    const Vec3 place = glm::normalize(line * glm::dot(line, away)) * kBeyond_m;
    Random random(1);
    for (int i = 0; i < 50; ++i) {
      const Vec3 hip = place - block * random.between(0.002, 0.02) - face * random.between(0.002, 0.02);
      ReferenceProxy reference(soup_);
      reference.resume(Vec3(0), hip);
      EXPECT_LT(glm::distance(reference.ihip(), place), 1e-9) << i;
    }
  }
};

TEST_F(EdgeInAGroove, HoldsTheReferenceOnlyWhereNeitherOfItsFacesLetsItOn) {
  ASSERT_LT(face_[0].y, 0);
  ASSERT_LT(face_[1].y, 0);
  expectsAWay({-1, 0, 0}, face_[0], {0, 0, 1});
  expectsAWay({0, 0, 1}, face_[1], {-1, 0, 0});
}

TEST(ReferenceProxy, LeavesASheetByACornerOfItsRim) {
  const Vec3 corner(0.0375, 0.0748, 0.0538);
  const std::vector<Vec3f> vertices{
      Vec3f(0), Vec3f(5.11993e-3, -3.88723e-3, 0.100302e-3), Vec3f(5.86598e-3, -0.988585e-3, 2.82294e-3),
      Vec3f(-0.356137e-3, -3.65473e-3, 0.944572e-3), Vec3f(-5.85641e-3, -0.177964e-3, 3.05307e-3)};
  const std::vector<TriangleIndices> triangles{{0, 1, 2}, {0, 3, 1}, {0, 4, 3}};
  TriangleSoup soup;
  soup.add(vertices, triangles, {{1, 0, 0, 0}, corner});
  soup.finish();
  const Vec3 before(0.744233e-3, 0.841507e-3, -2.555974e-3);
  const Vec3 hip(0.702503e-3, 0.875168e-3, -2.562368e-3);  // beyond the rim
  const Vec3 along(vertices[1]), across(vertices[2]);
  const Vec3 onFirst = 0.0068 * along + 1e-4 * across + 1e-12 * glm::normalize(glm::cross(along, across));
  for (const int parts : {1, 16, 64, 512, 4096}) {
    ReferenceProxy reference(soup);
    reference.resume(corner + onFirst, corner + before);
    ASSERT_TRUE(reference.touching());
    reference.follow(corner + hip, parts);
    EXPECT_FALSE(reference.touching()) << parts;
  }
}

}  // namespace
}  // namespace haptics::eval::reference_proxy_test
