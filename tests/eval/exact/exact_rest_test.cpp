// Places of the IHIP by rational numbers, beside the runtime's, brute force's, and what the failure scenes judge by.
#include "tests/eval/exact/exact_rest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/eval/accuracy_run.h"
#include "tests/eval/brute_force_proxy.h"
#include "tests/eval/exchange/plain_mesh.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/winding.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::exact_rest_test {
namespace {

double nearest_m(const std::vector<Vec3>& rests, Vec3 place) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3 rest : rests) least = std::min(least, glm::distance(rest, place));
  return least;
}

TEST(ExactRest, OfACubeIsEachFaceThatTheHipIsBelow) {
  const shapes::Shape cube = shapes::box(Vec3(0.125), 1);
  const std::vector<Vec3> rests = exactRests(cube.vertices, cube.triangles, {0.01, 0.02, 0.05});
  EXPECT_EQ(rests.size(), 6U);
  EXPECT_EQ(nearest_m(rests, {0.01, 0.02, 0.0625}), 0);
  // Below a diagonal and over the middle there are places on edges that are flat: still one for each face.
  EXPECT_EQ(exactRests(cube.vertices, cube.triangles, Vec3(0)).size(), 6U);
}

TEST(ExactRest, LiesInValleysAndCornersAndOnNoRidge) {
  shapes::Shape room = shapes::box(Vec3(0.125), 1);
  for (auto& triangle : room.triangles) std::swap(triangle[1], triangle[2]);
  const auto restIn = [&](Vec3 hip) {
    return nearest_m(exactRests(room.vertices, room.triangles, hip), glm::clamp(hip, Vec3(-0.0625), Vec3(0.0625)));
  };
  EXPECT_EQ(restIn({0.07, 0.01, 0.02}), 0);
  EXPECT_EQ(restIn({0.07, 0.08, 0.02}), 0);
  EXPECT_EQ(restIn({0.07, 0.08, -0.09}), 0);
  const shapes::Shape cube = shapes::box(Vec3(0.125), 1);
  for (const Vec3 rest : exactRests(cube.vertices, cube.triangles, {0.06, 0.06, 0.05})) {
    const Vec3 off = glm::abs(rest);
    EXPECT_EQ((off.x == 0.0625) + (off.y == 0.0625) + (off.z == 0.0625), 1);
  }
}

/// Along the paths of the accuracy's shapes, which lead over ridges and through valleys: brute force rests where it may.
TEST(ExactRest, IsWhereBruteForceComesTo) {
  constexpr int kTriangles = 192;
  constexpr double kDepth_m = 0.002, kStep_m = 1e-4;
  int compared = 0;
  for (const AnalyticShape& shape : analyticShapes()) {
    const Sample sample = makeSample(shape, kTriangles);
    const WindingMesh solid(sample.mesh.vertices, sample.mesh.triangles);
    BruteForceProxy brute(sample.mesh);
    bool touching = false;
    int tick = 0;
    for (double way_m = 0; way_m <= kPath_m; way_m += kStep_m, ++tick) {
      const Truth truth = shape.at(way_m, kDepth_m);
      if (!truth.touching) break;
      const bool isIn = solid.depthInside(truth.hip) > 0;  // of the mesh: it is within the shape, or beyond it
      if (isIn && !touching) brute.touch(truth.hip);
      touching = isIn;
      if (!isIn) continue;
      const Vec3 place = brute.follow(truth.hip);
      if (tick % 40 != 20) continue;
      EXPECT_LT(nearest_m(exactRests(sample.mesh.vertices, sample.mesh.triangles, truth.hip), place), 1e-9)
          << shape.name << " after " << way_m << " m";
      ++compared;
    }
  }
  EXPECT_GT(compared, 60);
}

/// Compares where a method holds the hand in a scene, on one body at rest of few triangles, every so many ticks.
class Compared final : public Renderer {
 public:
  explicit Compared(std::unique_ptr<Renderer> method) : method_(std::move(method)) {}

  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override {
    keep(bodies, poses);
    method_->begin(bodies, poses, hip);
  }
  void setSurfaceProperties(const FeltSurface& surface) override { method_->setSurfaceProperties(surface); }
  void place(Vec3 hip) override { method_->place(hip); }
  void edit(const EditedScene& scene, Vec3 hip) override {
    keep(scene.bodies, scene.poses);
    method_->edit(scene, hip);
  }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override { return compare(method_->tick(poses, hip), poses, hip); }
  Felt drive(std::span<const Pose> samples, bool haveCome, Vec3 hip) override {
    return method_->drive(samples, haveCome, hip);
  }
  [[nodiscard]] bool turnsMirroredOver() const override { return method_->turnsMirroredOver(); }

  [[nodiscard]] int compared() const { return compared_; }
  /// Of a method's place from the nearest place of rest, over the body's largest coordinate.
  [[nodiscard]] double worst() const { return worst_; }

 private:
  void keep(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses) {
    constexpr std::uint32_t kMostTriangles = 450;
    body_.reset();
    if (bodies.size() != 1 || !bodies[0]->closed() || bodies[0]->triangleCount() > kMostTriangles) return;
    body_.emplace(*bodies[0]);
    extent_m_ = std::max(glm::length(bodies[0]->low()), glm::length(bodies[0]->high()));
    poses_.assign(poses.begin(), poses.end());
  }
  Felt compare(const Felt& felt, std::span<const Pose> poses, Vec3 hip) {
    const int every = body_ && body_->triangles.size() < 100 ? 5 : 61;
    const bool atRest = std::ranges::equal(poses, poses_);
    poses_.assign(poses.begin(), poses.end());
    if (!body_ || !atRest || !felt.touching || felt.followed || ++ticks_ % every != 0) return felt;
    const Vec3 h = toLocal(poses[0], hip), place = toLocal(poses[0], felt.ihip);
    worst_ = std::max(worst_, nearest_m(exactRests(body_->vertices, body_->triangles, h), place) / extent_m_);
    ++compared_;
    return felt;
  }

  std::unique_ptr<Renderer> method_;
  std::optional<PlainMesh> body_;
  double extent_m_ = 1;
  std::vector<Pose> poses_;
  int ticks_ = 0, compared_ = 0;
  double worst_ = 0;
};

Compared runIn(std::string_view method, std::string_view scene) {
  Compared compared(findMethod(method, methods()).make());
  const auto* const of = std::ranges::find(kFailureScenes, scene, &FailureScene::name);
  Random random = of->random(1);
  (void)of->run(compared, random);
  return compared;
}

/// What the judges of these scenes have by a formula, by all triangles or by the winding number is what rational numbers
/// have: where these pass, the place is a place of rest to within the skin.
class Scenes : public testing::TestWithParam<const char*> {};

TEST_P(Scenes, HoldTheHandAtPlacesOfRest) {
  constexpr double kSkin = 0x1p-20;
  const Compared compared = runIn("ours", GetParam());
  EXPECT_GE(compared.compared(), 10);
  EXPECT_LT(compared.worst(), kSkin);
}

INSTANTIATE_TEST_SUITE_P(Of, Scenes, testing::Values("S1", "S8", "S9", "S39", "P3", "P4"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(ExactRest, IsNotWhereAMethodGoesWrong) { EXPECT_GT(runIn("pseudocode_closed", "S1").worst(), 0.01); }

}  // namespace
}  // namespace haptics::eval::exact_rest_test
