#include "common/scene/deformed_hash.h"

#include <gtest/gtest.h>

#include "common/deform/free_form.h"

namespace haptics::deformed_hash_test {
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
  const HeldShapes all{.vertices = [&](const ContentHash&) { return &vertices; },
                       .residue = [](const ContentHash&) { return nullptr; }};
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
  EXPECT_FALSE(deformedHash(scene, {.vertices = [](const ContentHash&) { return nullptr; }, .residue = {}}, {}));
}

TEST(DeformedHash, IsTheSameForDentsAndForTheResidueThatTheyBecome) {
  std::vector<Vec3f> vertices;
  for (int i = 0; i < 400; ++i) vertices.emplace_back(0.0011F * float(i % 20), 0.0013F * float(i / 20), 0.05F);
  DeformationProperties clay{.softness = Softness{.stiffness_N_per_m = 100, .radius_m = 0.008, .plastic = 1},
                             .lattice = {}};
  const std::vector<ObjectDent> dents{{1, {{0.008F, 0.01F, 0.05F}, {0.0003F, 0, -0.002F}}},
                                      {1, {{0.011F, 0.012F, 0.0487F}, {0, 0.0002F, -0.0015F}}},
                                      {1, {{0.012F, 0.009F, 0.0479F}, {0, 0, -0.001F}}}};
  std::vector<Vec3f> taken = vertices;
  for (Vec3f& v : taken) {
    for (int i = 0; i < 2; ++i) v = dented(v, {&dents[std::size_t(i)].dent, 1}, tissueOf(*clay.softness).falloff);
  }
  const MovedVertices moved = movedBetween(vertices, taken);
  ASSERT_GT(moved.vertex.size(), 50U);
  const HeldShapes held{.vertices = [&](const ContentHash&) { return &vertices; },
                        .residue = [&](const ContentHash& hash) { return hash == hashOf(moved) ? &moved : nullptr; }};
  const auto before = SceneVersion::fromSnapshot(1, {objectWith(1, clay)}).value();
  clay.residue = hashOf(moved);
  const auto after = SceneVersion::fromSnapshot(1, {objectWith(1, clay)}).value();
  EXPECT_EQ(deformedHash(before, held, dents).value(), deformedHash(after, held, {&dents[2], 1}).value());
  EXPECT_NE(deformedHash(before, held, dents).value(), deformedHash(after, held, {}).value());
  clay.residue = ContentHash{};
  EXPECT_FALSE(deformedHash(SceneVersion::fromSnapshot(1, {objectWith(1, clay)}).value(), held, {}));
}

}  // namespace
}  // namespace haptics::deformed_hash_test
