#include "common/scene/deformed_hash.h"

#include <gtest/gtest.h>

#include "common/deform/free_form.h"

namespace haptics {
namespace {

ObjectRecord objectWith(ObjectId id, DeformationProperties deformation) {
  ObjectRecord record;
  record.id = id;
  record.name = "object " + std::to_string(id);
  record.deformation = std::move(deformation);
  return record;
}

TEST(DeformedHash, IsOfTheVerticesWhereTheyAre) {
  const std::vector<Vec3f> vertices{{0, 0, 0}, {0.01F, 0, 0}, {0, 0.01F, 0}};
  const VerticesOf all = [&](const ContentHash&) { return &vertices; };
  const DeformationProperties soft{.softness = Softness{.stiffness_N_per_m = 100, .radius_m = 0.005}, .lattice = {}};
  const auto scene = SceneVersion::fromSnapshot(1, {objectWith(1, soft), objectWith(2, {})}).value();
  const ContentHash rest = deformedHash(scene, all, {}).value();
  const ObjectDent dent{1, {{0, 0, 0}, {0, 0, -0.001F}}};
  EXPECT_NE(deformedHash(scene, all, {&dent, 1}).value(), rest);
  const ObjectDent beside{1, {{0, 0, 1}, {0, 0, -0.001F}}};
  EXPECT_EQ(deformedHash(scene, all, {&beside, 1}).value(), rest) << "reaches no vertex";
  const ObjectDent inRigid{2, dent.dent};
  EXPECT_EQ(deformedHash(scene, all, {&inRigid, 1}).value(), rest);
  DeformationProperties bent = soft;
  bent.lattice = Lattice{Vec3(-0.02), Vec3(0.04), {2, 2, 2}, FreeForm::atRest(Vec3(-0.02), Vec3(0.04), {2, 2, 2})};
  bent.lattice->control_m[0].x -= 0.01F;
  const auto bentScene = SceneVersion::fromSnapshot(1, {objectWith(1, bent), objectWith(2, {})}).value();
  EXPECT_NE(deformedHash(bentScene, all, {}).value(), rest);
  EXPECT_FALSE(deformedHash(scene, [](const ContentHash&) { return nullptr; }, {}));
}

}  // namespace
}  // namespace haptics
