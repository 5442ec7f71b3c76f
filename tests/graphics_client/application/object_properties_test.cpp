#include "graphics_client/application/object_properties.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "common/wire/convert.h"

namespace haptics::object_properties_test {
namespace {

constexpr double kFloor_m = -0.02;

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
  void turn(const std::string& label, bool on) {
    v1::Operation operation;
    has(label).set(object, on, kFloor_m, operation);
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
        const double value = property.least + share * (property.most - property.least);
        set(property.label, value);
        EXPECT_NEAR(property.get(object).value(), value, 1e-9 * property.most) << property.label;
      }
    }
  }
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
