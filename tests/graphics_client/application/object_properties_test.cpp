#include "graphics_client/application/object_properties.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "common/wire/convert.h"

namespace haptics::object_properties_test {
namespace {

constexpr double kFloor_m = -0.02;
const Surroundings kAround{kFloor_m, {{-0.1, 0, 0}, {0.1, 0.02, 0.05}}};

const NumberProperty& number(const std::string& label) {
  for (const PropertyGroup& group : propertyGroups()) {
    for (const NumberProperty& property : group.numbers) {
      if (property.label == label) return property;
    }
  }
  throw std::out_of_range(label);
}

const SwitchProperty& has(const std::string& label) {
  for (const PropertyGroup& group : propertyGroups()) {
    for (const SwitchProperty& property : group.switches) {
      if (property.label == label) return property;
    }
  }
  throw std::out_of_range(label);
}

/// The object after an operation, as the server applies it.
struct Edited : testing::Test {
  ObjectRecord object;

  Edited() { object.name = "cup"; }

  void apply(v1::Operation operation) {
    setObject(operation, object.name);
    v1::Transaction message;
    *message.add_operations() = std::move(operation);
    const auto transaction = fromWire(message);
    ASSERT_TRUE(transaction) << transaction.error().text();
    const Operation& made = transaction->operations.at(0);
    if (const auto* set = std::get_if<SetPose>(&made)) object.pose = edited(object.pose, set->pose);
    if (const auto* set = std::get_if<SetMaterial>(&made)) object.material = edited(object.material, set->material);
    if (const auto* set = std::get_if<SetMotion>(&made)) object.motion = set->motion;
    if (const auto* set = std::get_if<SetDeformation>(&made)) {
      object.deformation = edited(object.deformation, set->deformation);
    }
  }
  void set(const std::string& label, double value) {
    v1::Operation operation;
    number(label).set(object, value, operation);
    apply(std::move(operation));
  }
  void choose(std::size_t entry);
  void turn(const std::string& label, bool on) {
    v1::Operation operation;
    has(label).set(object, on, kAround, operation);
    apply(std::move(operation));
  }
};

TEST_F(Edited, HasEachNumberThatIsSet) {
  object.material.surface.texture = Texture{.family = NoiseFamily{0.01}, .amplitude_m = 1e-3};
  turn("soft", true);
  turn("moves", true);
  for (const PropertyGroup& group : propertyGroups()) {
    for (const NumberProperty& property : group.numbers) {
      for (const double share : {0.5, 0.25}) {
        if (property.isHidden) continue;
        const double value = property.least + share * (property.most - property.least);
        set(property.label, value);
        EXPECT_NEAR(property.get(object).value(), value, 1e-9 * property.most) << property.label;
      }
    }
  }
}

const ChoiceProperty& joint() {
  for (const PropertyGroup& group : propertyGroups()) {
    if (!group.choices.empty()) return group.choices.front();
  }
  throw std::out_of_range("joint");
}

void Edited::choose(std::size_t entry) {
  v1::Operation operation;
  ASSERT_TRUE(joint().set(object, entry, kAround, operation));
  apply(std::move(operation));
}

TEST_F(Edited, TurnsAboutAHingeAndSlidesAndIsFreeAgain) {
  EXPECT_FALSE(joint().get(object));
  turn("moves", true);
  EXPECT_EQ(joint().get(object), 0U);
  choose(1);
  ASSERT_EQ(joint().get(object), 1U);
  EXPECT_EQ(object.motion->joint->anchor_m, Vec3(0, 0.01, 0.025)) << "the middle of the box around it";
  EXPECT_FALSE(has("stops at ends").get(object));
  EXPECT_FALSE(number("turns to").get(object));
  turn("stops at ends", true);
  set("turns to", 30);
  EXPECT_NEAR(object.motion->joint->highest, std::numbers::pi / 6, 1e-12);
  EXPECT_NEAR(number("turns from").get(object).value(), -90, 1e-9);
  EXPECT_FALSE(number("slides to").get(object));
  set("anchor y", 40);
  set("axis x", 0.6);
  EXPECT_NEAR(glm::distance(object.motion->joint->axis, Vec3(0.6, 0, 0.8)), 0, 1e-12);
  choose(2);
  EXPECT_FALSE(has("stops at ends").get(object)) << "of the hinge";
  EXPECT_EQ(object.motion->joint->anchor_m.y, 0.04);
  EXPECT_NEAR(object.motion->joint->axis.x, 0.6, 1e-12);
  turn("stops at ends", true);
  set("slides from", -20);
  EXPECT_NEAR(object.motion->joint->lowest, -0.02, 1e-12);
  choose(0);
  EXPECT_FALSE(object.motion->joint);
  ASSERT_EQ(object.motion->planes.size(), 1U);
  EXPECT_EQ(object.motion->planes[0].offset_m, kFloor_m);
}

TEST_F(Edited, IsTheToolAndNoToolAgain) {
  turn("tool", true);
  EXPECT_NEAR(object.motion->tool->spacing_m, 0.2 / 25, 1e-12);
  EXPECT_FALSE(has("moves").get(object));
  EXPECT_FALSE(joint().get(object));
  set("tool torsion", 2);
  set("tool spacing", 4);
  EXPECT_EQ(object.motion->tool->torsion_Nm_per_rad, 2);
  EXPECT_EQ(object.motion->tool->spacing_m, 0.004);
  turn("tool", false);
  EXPECT_FALSE(object.motion);
}

TEST_F(Edited, HasNumbersOfWhatItIsOnly) {
  for (const char* label : {"texture height", "texture size", "tissue stiffness", "dent radius", "mass", "gravity"}) {
    EXPECT_FALSE(number(label).get(object)) << label;
  }
}

TEST_F(Edited, IsSoftAndRigidAgain) {
  turn("soft", true);
  EXPECT_TRUE(has("soft").get(object));
  set("dents that stay", 0.5);
  set("tissue stiffness", 100);
  EXPECT_EQ(object.deformation.softness->plastic, 0.5) << "the rest of the softness is kept";
  turn("soft", false);
  EXPECT_FALSE(has("soft").get(object));
  EXPECT_FALSE(object.deformation.softness);
}

TEST_F(Edited, MovesOnTheFloorAndStandsAgain) {
  turn("moves", true);
  ASSERT_TRUE(has("moves").get(object));
  ASSERT_EQ(object.motion->planes.size(), 1U);
  EXPECT_EQ(object.motion->planes[0].offset_m, kFloor_m);
  EXPECT_NEAR(number("gravity").get(object).value(), 9.81, 1e-12);
  set("gravity", 0);
  set("mass", 2);
  EXPECT_EQ(object.motion->gravity_m_per_s2, Vec3(0));
  EXPECT_EQ(object.motion->planes.size(), 1U) << "the rest of the motion is kept";
  turn("moves", false);
  EXPECT_FALSE(has("moves").get(object));
  EXPECT_TRUE(has("meets others").get(object)) << "what moves is stopped by it as before";
}

TEST_F(Edited, MeetsOthersOnceItMovesAndStayingToo) {
  turn("moves", true);
  EXPECT_TRUE(has("meets others").get(object));
  turn("meets others", false);
  EXPECT_FALSE(has("meets others").get(object));
  EXPECT_TRUE(has("moves").get(object));
  turn("moves", false);
  EXPECT_FALSE(object.motion);
  turn("meets others", true);
  EXPECT_TRUE(object.motion->fixed);
  turn("meets others", false);
  EXPECT_FALSE(object.motion);
}

TEST_F(Edited, HasTheColourThatIsChosen) {
  for (const std::array<int, 3> color : {std::array{0, 128, 255}, std::array{3, 200, 17}}) {
    v1::Operation operation;
    setShownColor(color, operation);
    apply(std::move(operation));
    EXPECT_EQ(shownColor(object.material.color), color);
  }
}

TEST_F(Edited, SlidesWithNoMoreFrictionThanItSticksWith) {
  set("static friction", 0.8);
  set("dynamic friction", 0.5);
  EXPECT_EQ(object.material.surface.friction->mu_static, 0.8);
  set("static friction", 0.3);
  EXPECT_EQ(object.material.surface.friction->mu_dynamic, 0.3);
  set("dynamic friction", 1);
  EXPECT_EQ(object.material.surface.friction->mu_static, 1);
}

TEST_F(Edited, ShowsNoPlainFrictionWhereThatVaries) {
  object.material.surface.friction = Friction{.mu_static = 1, .mu_dynamic = 1, .dynamicOver = PerVertexScale{}};
  EXPECT_FALSE(number("static friction").get(object));
}

/// Beyond what is usual it is the server's to decide: the operation asks for what was typed.
TEST_F(Edited, AsksForWhatIsTyped) {
  v1::Operation operation;
  number("stiffness").set(object, -5, operation);
  EXPECT_EQ(operation.set_material().material().stiffness_n_per_m(), -5);
  number("shading").set(object, -5, operation);
  EXPECT_LT(operation.set_material().material().shading().crease_rad(), 0);
}

}  // namespace
}  // namespace haptics::object_properties_test
