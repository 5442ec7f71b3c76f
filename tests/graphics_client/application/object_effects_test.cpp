#include "graphics_client/application/object_effects.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <variant>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"

namespace haptics::object_effects_test {
namespace {

using Kind = Effect::Kind;
using Region = Effect::Region;
using testing::HasSubstr;

const Surroundings kAround{
    0, {{-0.1, 0, 0}, {0.1, 0.02, 0.05}}, {glm::angleAxis(std::numbers::pi / 2, Vec3(0, 0, 1)), {0.3, 0, 0}}};

/// The object after an operation, as the server applies it.
struct WithEffects : testing::TestWithParam<Kind> {
  ObjectRecord object;

  WithEffects() { object.name = "cup"; }

  /// Empty: it was accepted.
  std::string apply(v1::Operation operation) {
    setObject(operation, object.name);
    v1::Transaction message;
    *message.add_operations() = std::move(operation);
    const auto transaction = fromWire(message);
    if (!transaction) return transaction.error().text();
    const Operation& made = transaction->operations.at(0);
    if (const auto* set = std::get_if<SetEffects>(&made)) object.effects = set->effects;
    if (const auto* set = std::get_if<SetMotion>(&made)) object.motion = set->motion;
    return "";
  }
  EffectPlace add(Kind kind) {
    v1::Operation operation;
    addEffect(object, usualEffect(kind, kAround.box), operation);
    EXPECT_EQ(apply(std::move(operation)), "") << effectName(kind);
    return {object.effects.size() - 1, kind};
  }
  std::string set(const EffectPlace& place, const std::string& label, double value) {
    const auto rows = effectNumbers(place);
    const auto row = std::ranges::find(rows, label, &NumberProperty::label);
    if (row == rows.end() || !row->get(object)) return "no " + label;
    v1::Operation operation;
    row->set(object, value, operation);
    return apply(std::move(operation));
  }
  std::string choose(const EffectPlace& place, const std::string& label, const std::string& entry) {
    for (const ChoiceProperty& row : effectChoices(place)) {
      if (row.label != label) continue;
      v1::Operation operation;
      const auto at = std::ranges::find(row.entries, entry) - row.entries.begin();
      EXPECT_TRUE(row.set(object, static_cast<std::size_t>(at), kAround, operation));
      const std::string refusal = apply(std::move(operation));
      EXPECT_EQ(row.get(object), static_cast<std::size_t>(at));
      return refusal;
    }
    return "no " + label;
  }
};

std::string nameOf(const testing::TestParamInfo<Kind>& info) { return std::to_string(static_cast<int>(info.param)); }

INSTANTIATE_TEST_SUITE_P(EachKind, WithEffects, testing::ValuesIn(effectKinds()), nameOf);

TEST_P(WithEffects, IsTakenAsItIsAddedAndHasEachNumberThatIsSet) {
  const EffectPlace place = add(GetParam());
  for (const NumberProperty& property : effectNumbers(place)) {
    if (!property.get(object)) continue;
    EXPECT_GT(std::string(property.tip), "") << property.label;
    const double before = *property.get(object), value = property.least + 0.3 * (property.most - property.least);
    EXPECT_EQ(set(place, property.label, value), "");
    EXPECT_NEAR(property.get(object).value(), value, 1e-9 * property.most) << property.label;
    EXPECT_EQ(set(place, property.label, before), "");
  }
}

TEST_P(WithEffects, IsInEachRegionAndFrameThatItsKindHas) {
  const EffectPlace place = add(GetParam());
  const bool isOfMesh =
      GetParam() == Kind::kMagnet || GetParam() == Kind::kSpringToVertex || GetParam() == Kind::kSpringToEdge;
  if (!isOfMesh) {
    EXPECT_EQ(choose(place, "frame", "world"), "");
  }
  EXPECT_EQ(choose(place, "frame", "object"), "");
  if (!usesField(GetParam(), "region")) return;
  EXPECT_EQ(set(place, "fade", 1), "no fade");
  for (const char* region : {"box", "sphere", "box", "everywhere", "sphere", "inside", "box"}) {
    EXPECT_EQ(choose(place, "region", region), "") << region;
    EXPECT_EQ(set(place, "fade", 2), region == std::string("everywhere") ? "no fade" : "") << region;
  }
  EXPECT_EQ(choose(place, "felt", "touch"), "");
}

TEST_F(WithEffects, KeepsItsOthers) {
  add(Kind::kMagnet);
  const EffectPlace second = add(Kind::kViscosity);
  add(Kind::kSpringToPoint);
  const auto before = object.effects;
  EXPECT_EQ(set(second, "damping", 7), "");
  EXPECT_EQ(object.effects[1].damping_Ns_per_m, 7);
  EXPECT_EQ(object.effects[0], before[0]);
  EXPECT_EQ(object.effects[2], before[2]);
  v1::Operation operation;
  ASSERT_TRUE(removeEffect(object, second, operation));
  EXPECT_EQ(apply(std::move(operation)), "");
  EXPECT_EQ(object.effects, (std::vector{before[0], before[2]}));
  EXPECT_EQ(removeEffect(object, second, operation).error().text(), "viscosity: is not there any more")
      << "another has taken its place";
  EXPECT_EQ(set(second, "damping", 1), "no damping");
}

TEST_F(WithEffects, ReleasesBeyondItsReachAndFadesWithin) {
  const EffectPlace place = add(Kind::kSpringToPoint);
  EXPECT_EQ(set(place, "release", 40), "");
  EXPECT_EQ(set(place, "reach", 60), "");
  EXPECT_EQ(object.effects[0].release_m, 0.06);
  EXPECT_EQ(set(place, "fade", 80), "");
  EXPECT_EQ(object.effects[0].fade_m, 0.06);
  EXPECT_EQ(set(place, "reach", 0), "");
  EXPECT_EQ(set(place, "release", 10), "no release");
}

TEST_F(WithEffects, StaysWhereItIsAsItsFrameChanges) {
  const EffectPlace place = add(Kind::kSpringToLine);
  const Vec3 point = object.effects[0].point_m;
  EXPECT_EQ(choose(place, "frame", "world"), "");
  EXPECT_NEAR(glm::distance(object.effects[0].point_m, toWorld(kAround.pose, point)), 0, 1e-12);
  EXPECT_NEAR(glm::distance(object.effects[0].direction, Vec3(0, 1, 0)), 0, 1e-12);
  EXPECT_EQ(choose(place, "frame", "object"), "");
  EXPECT_NEAR(glm::distance(object.effects[0].point_m, point), 0, 1e-12);
}

TEST_F(WithEffects, HasSpotsThatHandlesMove) {
  const EffectPlace guide = add(Kind::kGuide), plane = add(Kind::kSpringToPlane), push = add(Kind::kConstant),
                    magnet = add(Kind::kMagnet);
  const auto moved = [this](const HandleSpot& spot, const SpotState& to) {
    v1::Operation operation;
    EXPECT_TRUE(setSpot(object, spot, to, operation));
    EXPECT_EQ(apply(std::move(operation)), "");
    return spotState(object, spot).value();
  };
  EXPECT_EQ(moved({guide, 1}, {.point_m = Vec3(1, 2, 3)}).point_m, Vec3(1, 2, 3));
  EXPECT_EQ(object.effects[0].path_m[1], Vec3(1, 2, 3));
  EXPECT_FALSE(spotState(object, {guide, 1})->direction);
  EXPECT_FALSE(spotState(object, {guide, 3})) << "it has three points";
  const SpotState turned = moved({plane}, {.point_m = Vec3(0, 0, 1), .direction = Vec3(1, 0, 0)});
  EXPECT_EQ(turned.point_m, Vec3(0, 0, 1));
  EXPECT_EQ(turned.direction, Vec3(1, 0, 0));
  EXPECT_FALSE(spotState(object, {push})->point_m) << "it acts everywhere";
  EXPECT_EQ(moved({push}, {.direction = Vec3(0, 1, 0)}).direction, Vec3(0, 1, 0));
  EXPECT_FALSE(spotState(object, {magnet}));
  EXPECT_FALSE(spotState(object, {})) << "no joint";
  object.motion = MotionProperties{.mass_kg = 1, .joint = JointProperties{.lowest = -1, .highest = 1}};
  EXPECT_EQ(moved({}, {.point_m = Vec3(0.1, 0, 0), .direction = Vec3(1, 0, 0)}).point_m, Vec3(0.1, 0, 0));
  EXPECT_EQ(object.motion->joint->highest, 1);
}

TEST_F(WithEffects, GainsAndLosesPointsOfItsPath) {
  const EffectPlace guide = add(Kind::kGuide);
  object.effects[0].path_m = {Vec3(0), Vec3(1, 0, 0)};
  for (const auto& [after, expected] : {std::pair{0U, Vec3(0.5, 0, 0)}, std::pair{2U, Vec3(1.5, 0, 0)}}) {
    v1::Operation operation;
    ASSERT_TRUE(addPathPoint(object, guide, after, operation));
    EXPECT_EQ(apply(std::move(operation)), "");
    EXPECT_EQ(object.effects[0].path_m[after + 1], expected);
  }
  for (int i = 0; i < 2; ++i) {
    v1::Operation operation;
    ASSERT_TRUE(removePathPoint(object, guide, 1, operation));
    EXPECT_EQ(apply(std::move(operation)), "");
  }
  EXPECT_EQ(object.effects[0].path_m, (std::vector{Vec3(0), Vec3(1.5, 0, 0)}));
  v1::Operation operation;
  ASSERT_TRUE(removePathPoint(object, guide, 1, operation));
  EXPECT_THAT(apply(std::move(operation)), HasSubstr("at least two points"));
  EXPECT_EQ(pathNumbers(guide, 1)[0].get(object), 1500);
}

}  // namespace
}  // namespace haptics::object_effects_test
