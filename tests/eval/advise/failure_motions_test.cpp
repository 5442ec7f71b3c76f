#include "tests/eval/advise/failure_motions.h"

#include <gmock/gmock.h>

#include "common/mesh/generators.h"

namespace haptics::eval::failure_motions_test {
namespace {

using testing::AllOf;
using testing::Each;
using testing::Field;
using testing::Gt;
using testing::Property;
using testing::SizeIs;

LoadedObject objectOf(const TriMesh& mesh) {
  return {.name = "it",
          .material = {},
          .pose = {glm::angleAxis(0.3, Vec3(1, 0, 0)), {0.02, 0, 0.03}},
          .mesh = std::make_shared<const TriMesh>(mesh),
          .surface = buildCollisionMesh(mesh.vertices, mesh.triangles)};
}

TEST(FailureMotions, HoldOnABoxAndAPlate) {
  for (const Vec3 size_m : {Vec3(0.05, 0.04, 0.03), Vec3(0.08, 0.08, 0.002)}) {
    const LoadedObject box = objectOf(makeBox(size_m, 4).value());
    EXPECT_THAT(failureMotionsOf(servoSceneOf({box}), box, strokesOver(box)),
                AllOf(SizeIs(3), Each(Property(&FailureMotion::holds, true))));
  }
}

TEST(FailureMotions, FindTheIhipInsideWhereNothingHoldsIt) {
  const LoadedObject box = objectOf(makeBox({0.05, 0.04, 0.03}, 4).value());
  const LoadedObject elsewhere = {.name = box.name,
                                  .material = box.material,
                                  .pose = {{1, 0, 0, 0}, {5, 0, 0}},
                                  .mesh = box.mesh,
                                  .surface = box.surface};
  EXPECT_THAT(failureMotionsOf(servoSceneOf({elsewhere}), box, strokesOver(box)),
              AllOf(SizeIs(3), Each(AllOf(Property(&FailureMotion::holds, false),
                                          Field(&FailureMotion::deepestInside_mm, Gt(1.0))))));
}

TEST(FailureMotions, AreNotTriedOnWhatHasNoInside) {
  TriMesh open = makeBox({0.05, 0.04, 0.03}, 4).value();
  open.triangles.pop_back();
  const LoadedObject sheet = objectOf(open);
  EXPECT_THAT(failureMotionsOf(servoSceneOf({sheet}), sheet, strokesOver(sheet)), SizeIs(0));
}

}  // namespace
}  // namespace haptics::eval::failure_motions_test
