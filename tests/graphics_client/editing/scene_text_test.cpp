#include "graphics_client/editing/scene_text.h"

#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "common/wire/convert.h"

namespace haptics::scene_text_test {
namespace {

ObjectRecord record(ObjectId id, const std::string& name) {
  ObjectRecord object;
  object.id = id;
  object.name = name;
  object.mesh = Hasher().add(std::string_view(name)).finish();
  object.pose = {glm::normalize(Quat(0.9, 0.1, -0.2, 0.3)), {0.1, -0.25, 1.0 / 3}};
  object.material = {1234.5, 0.1, {0.25F, 0.5F, 1.0F / 3}};
  SurfaceProperties& surface = object.material.surface;
  surface.shading = Shading{0.5, {{1, 2}}};
  surface.friction = Friction{0.6, 0.3, 0.5, FieldFamily{GrainFamily{0.001, 7}}};
  surface.texture = Texture{.family = FourierFamily{{{1, {0, 0, 1}, 0.002, 0.1}}}, .amplitude_m = 1.0 / 3000};
  object.motion = MotionProperties{
      .mass_kg = 1.0 / 3,
      .gravity_m_per_s2 = Vec3(0),
      .spring = {.stiffness_N_per_m = 100, .damping_Ns_per_m = 0.1},
      .joint = JointProperties{JointProperties::Kind::kSlider, {}, {0, 1, 0}, -0.1, 0.2},
  };
  return object;
}

SceneVersion twoObjects() { return SceneVersion::fromSnapshot(5, {record(1, "ball"), record(4, "cup")}).value(); }

TEST(SceneText, IsReadBackToTheSameObjects) {
  const SceneVersion scene = twoObjects();
  const auto message = parseSceneText(sceneText(scene, ""), "test");
  ASSERT_TRUE(message) << message.error().text();
  const auto transaction = fromWire(*message);
  ASSERT_TRUE(transaction) << transaction.error().text();
  ASSERT_EQ(transaction->operations.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& add = std::get<AddObject>(transaction->operations[i]);
    const ObjectRecord& object = *scene.objects()[i];
    EXPECT_EQ(add.name, object.name);
    EXPECT_EQ(std::get<AssetSource>(add.mesh.source).hash, object.mesh);
    EXPECT_EQ(edited(Material{}, add.material), object.material);
    EXPECT_EQ(add.motion, object.motion);
    const Pose pose = edited(Pose{}, add.pose);
    EXPECT_EQ(pose.position, object.pose.position);
    EXPECT_EQ(pose.rotation, object.pose.rotation);
  }
}

TEST(SceneText, OfOneObjectHoldsOnlyIt) {
  const std::string text = sceneText(twoObjects(), "cup");
  EXPECT_NE(text.find("\"cup\""), std::string::npos);
  EXPECT_EQ(text.find("\"ball\""), std::string::npos);
}

TEST(SceneText, OfAnEmptySceneIsEmpty) { EXPECT_EQ(sceneText(SceneVersion{}, ""), ""); }

}  // namespace
}  // namespace haptics::scene_text_test
