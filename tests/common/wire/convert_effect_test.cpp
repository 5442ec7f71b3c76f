#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"

namespace haptics::convert_effect_test {
namespace {

using testing::HasSubstr;

v1::AddObject parse(const std::string& text) {
  v1::AddObject message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &message)) << text;
  return message;
}

std::string effect(const std::string& kind, const std::string& rest) {
  return "effects { kind: EFFECT_KIND_" + kind + " " + rest + " }";
}
const std::string kAlongZ = "direction { z: 1 } ";
const std::string kSpring = "stiffness_N_per_m: 200 ";
const std::string kPath = "path_m: [0, 0, 0, 0.1, 0, 0] ";

std::string times(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

std::string texture(const std::string& speeds, const std::string& forces, const std::string& models) {
  return "amplitude_N: 1 sample_rate_Hz: 1e4 speeds_m_per_s: [" + speeds + "] forces_N: [" + forces + "] models: [" +
         models + "] ";
}

struct BadEffect {
  std::string text;
  std::string field;
  std::string reason;  // part of what is said
};

void PrintTo(const BadEffect& bad, std::ostream* out) { *out << bad.text; }

class RefusedEffect : public testing::TestWithParam<BadEffect> {};

TEST_P(RefusedEffect, NamesItsFieldAndWhatWouldBeRight) {
  const v1::AddObject message = parse(GetParam().text);
  for (const auto& result : {effectsFrom(message.effects()), announcedEffectsFrom(message.effects())}) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().field, "effects[0]." + GetParam().field);
    EXPECT_THAT(result.error().reason, HasSubstr(GetParam().reason));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Effects, RefusedEffect,
    testing::ValuesIn(std::vector<BadEffect>{
        {"effects { }", "kind", "is missing; give EFFECT_KIND_CONSTANT, EFFECT_KIND_SPRING_TO_POINT"},
        {"effects { kind: 77 }", "kind", "is 77; give EFFECT_KIND_CONSTANT"},
        {effect("SPRING_TO_POINT", kSpring + "frame: 9"), "frame",
         "is 9; give EFFECT_FRAME_OBJECT or EFFECT_FRAME_WORLD"},
        {effect("CONSTANT", "amplitude_N: 1 direction { }"), "direction", "length 0"},
        {effect("CONSTANT", "amplitude_N: 1"), "direction", "length 0"},
        {effect("CONSTANT", "amplitude_N: 1 direction { x: 2 }"), "direction", "has length 2"},
        {effect("CONSTANT", "amplitude_N: 1 direction { x: nan }"), "direction", "nan"},
        {effect("CONSTANT", kAlongZ), "amplitude_N", "more than 0"},
        {effect("CONSTANT", kAlongZ + "amplitude_N: inf"), "amplitude_N", "is inf"},
        {effect("CONSTANT", kAlongZ + "amplitude_N: 1 stiffness_N_per_m: 5"), "stiffness_N_per_m",
         "EFFECT_KIND_CONSTANT does not use it"},
        {effect("CONSTANT", kAlongZ + "amplitude_N: 1 fade_m: 0.1"), "fade_m", "without a region"},
        {effect("CONSTANT", kAlongZ + "amplitude_N: 1 region: EFFECT_REGION_BOX size_m { x: 1 y: 1 }"), "size_m.z",
         "more than 0"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 region: EFFECT_REGION_SPHERE"), "size_m.x", "more than 0"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 region: EFFECT_REGION_SPHERE size_m { x: 1 y: 1 }"), "size_m",
         "diameter"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 region: 7"), "region", "is 7"},
        {effect("VISCOSITY", ""), "damping_Ns_per_m", "more than 0"},
        {effect("SPRING_TO_POINT", ""), "stiffness_N_per_m", "more than 0"},
        {effect("SPRING_TO_POINT", "stiffness_N_per_m: nan"), "stiffness_N_per_m", "is nan"},
        {effect("SPRING_TO_POINT", "stiffness_N_per_m: 1e9"), "stiffness_N_per_m", "at most 100000 N/m"},
        {effect("SPRING_TO_POINT", kSpring + "damping_Ns_per_m: -1"), "damping_Ns_per_m", "give 0 to 1000"},
        {effect("SPRING_TO_POINT", kSpring + "reach_m: 0"), "reach_m", "more than 0"},
        {effect("SPRING_TO_POINT", kSpring + "reach_m: nan"), "reach_m", "is nan"},
        {effect("SPRING_TO_POINT", kSpring + "release_m: 0.1"), "release_m", "without reach_m"},
        {effect("SPRING_TO_POINT", kSpring + "reach_m: 0.1 release_m: 0.05"), "release_m", "at least reach_m, 0.1"},
        {effect("SPRING_TO_POINT", kSpring + "reach_m: 0.1 fade_m: 0.2"), "fade_m", "at most the way to the border"},
        {effect("SPRING_TO_POINT", kSpring + "limit_N: 0"), "limit_N", "more than 0"},
        {effect("SPRING_TO_POINT", kSpring + "point_m { y: nan }"), "point_m.y", "nan"},
        {effect("SPRING_TO_POINT", kSpring + "frequency_Hz: 5"), "frequency_Hz", "does not use it"},
        {effect("SPRING_TO_LINE", kSpring), "direction", "length 0"},
        {effect("SPRING_TO_PATH", kSpring), "path_m", "at least two points"},
        {effect("SPRING_TO_PATH", kSpring + "path_m: [0, 0, 0, 1]"), "path_m", "has 4 numbers"},
        {effect("GUIDE", kSpring + "path_m: [0, 0, 0, 1, nan, 1]"), "path_m[4]", "nan"},
        {effect("GUIDE", kSpring + "path_m: [0, 0, 0, 1, 1, 1, 1, 1, 1]"), "path_m", "points 1 and 2"},
        {effect("GUIDE", kSpring + kPath + kAlongZ), "direction", "does not use it"},
        {effect("VIBRATION", kAlongZ + "amplitude_N: 1"), "frequency_Hz", "more than 0"},
        {effect("VIBRATION", kAlongZ + "amplitude_N: 1 frequency_Hz: 5000"), "frequency_Hz", "at most 500 Hz"},
        {effect("VIBRATION", kAlongZ + "amplitude_N: 1 frequency_Hz: 50 phase_rad: 60"), "phase_rad", "-10 to 10"},
        {effect("FORBIDDEN_SIDE", kAlongZ), "stiffness_N_per_m", "more than 0"},
        {effect("FORBIDDEN_SIDE", kAlongZ + kSpring + "reach_m: 1"), "reach_m", "does not use it"},
        {effect("TUBE", kSpring + kPath), "size_m.x", "more than 0"},
        {effect("TUBE", kSpring + kPath + "size_m { x: 0.1 z: 1 }"), "size_m", "of a tube only x is used"},
        {effect("TUBE", kSpring + "size_m { x: 0.1 }"), "path_m", "at least two points"},
        {effect("INERTIA", kSpring), "mass_kg", "more than 0"},
        {effect("INERTIA", "mass_kg: 0.1"), "stiffness_N_per_m", "more than 0"},
        {effect("INERTIA", kSpring + "mass_kg: 1e-9"), "mass_kg", "at least 0.001"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 mass_kg: 1"), "mass_kg", "does not use it"},
        {effect("MAGNET", kSpring), "reach_m", "is missing"},
        {effect("MAGNET", kSpring + "reach_m: 0.01 frame: EFFECT_FRAME_WORLD"), "frame", "moves with it"},
        {effect("SPRING_TO_VERTEX", "reach_m: 0.01"), "stiffness_N_per_m", "more than 0"},
        {effect("SPRING_TO_EDGE", kSpring + "reach_m: 0.01 point_m { x: 1 }"), "point_m", "does not use it"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 region: EFFECT_REGION_INSIDE size_m { x: 1 }"), "size_m",
         "has its own"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 region: EFFECT_REGION_INSIDE frame: EFFECT_FRAME_WORLD"), "frame",
         "moves with it"},
        {effect("SAMPLES", kAlongZ + "amplitude_N: 1 sample_rate_Hz: 8000 samples: 1"), "samples", "has 1; give 2 to"},
        {effect("SAMPLES", kAlongZ + "amplitude_N: 1 sample_rate_Hz: 8000 samples: [0, 1.5]"), "samples[1]",
         "give -1 to 1"},
        {effect("SAMPLES", kAlongZ + "amplitude_N: 1 sample_rate_Hz: 8000 samples: [nan, 1]"), "samples[0]", "nan"},
        {effect("SAMPLES", kAlongZ + "amplitude_N: 1 samples: [0, 1]"), "sample_rate_Hz", "more than 0"},
        {effect("SAMPLES", kAlongZ + "samples: [0, 1] sample_rate_Hz: 8000"), "amplitude_N", "more than 0"},
        {effect("RECORDED_TEXTURE", texture("", "1", "1, 0.5")), "speeds_m_per_s", "has 0; give 1 to 64"},
        {effect("RECORDED_TEXTURE", texture("0.1", "", "1, 0.5")), "forces_N", "has 0; give 1 to 64"},
        {effect("RECORDED_TEXTURE", texture("0.1, nan", "1", "1, 0, 1, 0")), "speeds_m_per_s[1]", "nan"},
        {effect("RECORDED_TEXTURE", texture("0.1, 0.1", "1", "1, 0, 1, 0")), "speeds_m_per_s[1]",
         "more than the one before, 0.1"},
        {effect("RECORDED_TEXTURE", texture("0.1", "0", "1, 0.5")), "forces_N[0]", "is 0"},
        {effect("RECORDED_TEXTURE", texture("0.1, 0.2", "1", "1, 0.5, 1")), "models", "has 3 numbers for 2 models"},
        {effect("RECORDED_TEXTURE", texture("0.1, 0.2", "1", "1, 1")), "models", "1 to 32"},
        {effect("RECORDED_TEXTURE", texture("0.1", "1", "1" + times(", 0", 33))), "models", "has 34 numbers"},
        {effect("RECORDED_TEXTURE", texture("1, 2, 3, 4, 5, 6, 7, 8, 9", "1, 2, 3, 4, 5, 6, 7, 8", "1, 1")),
         "speeds_m_per_s", "make 72 pairs; at most 64"},
        {effect("RECORDED_TEXTURE", texture("0.1", "1", "2, 0.5")), "models[0]", "give 0 to 1"},
        {effect("RECORDED_TEXTURE", texture("0.1", "1", "1, 0.5, -1")), "models[2]", "poles on the unit circle"},
        {effect("RECORDED_TEXTURE", texture("0.1", "1", "1, nan")), "models[1]", "nan"},
        {effect("RECORDED_TEXTURE", texture("0.1", "1", "1, 0") + kAlongZ), "direction", "does not use it"},
        {effect("RECORDED_TEXTURE", texture("0.1", "1", "1, 0") + "frame: EFFECT_FRAME_WORLD"), "frame",
         "moves with it"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 models: 1"), "models", "does not use it"},
        {effect("VISCOSITY", "damping_Ns_per_m: 1 trigger: 9"), "trigger", "is 9; give EFFECT_TRIGGER_ALWAYS"},
    }));

TEST(ConvertEffect, APathOfAHundredThousandPointsIsRefused) {
  v1::AddObject message;
  v1::Effect& guide = *message.add_effects();
  guide.set_kind(v1::EFFECT_KIND_GUIDE);
  guide.set_stiffness_n_per_m(100);
  for (int i = 0; i < 300'000; ++i) guide.add_path_m(1e-4 * i);
  const auto result = effectsFrom(message.effects());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().field, "effects[0].path_m");
  EXPECT_THAT(result.error().reason, HasSubstr("has 100000 points; at most 4096"));
}

/// An hour at 100 Hz.
TEST(ConvertEffect, AnHourOfSamplesIsRefused) {
  v1::AddObject message;
  v1::Effect& sound = *message.add_effects();
  sound.set_kind(v1::EFFECT_KIND_SAMPLES);
  sound.set_amplitude_n(1);
  sound.mutable_samples()->Resize(100 * 3600, 0.5F);
  const auto result = effectsFrom(message.effects());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().field, "effects[0].samples");
  EXPECT_THAT(result.error().reason, HasSubstr("has 360000; give 2 to 65536"));
}

TEST(ConvertEffect, ASecondRecordedTextureIsRefused) {
  const std::string one = effect("RECORDED_TEXTURE", texture("0.1", "1", "1, 0.5"));
  const auto result = effectsFrom(parse(one + effect("VISCOSITY", "damping_Ns_per_m: 1") + one).effects());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().field, "effects[2].kind");
}

TEST(ConvertEffect, MoreThanASceneHasAreRefused) {
  v1::AddObject message;
  for (int i = 0; i < 33; ++i) message.add_effects();
  const auto result = effectsFrom(message.effects());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().field, "effects");
}

TEST(ConvertEffect, AStateKeepsEachKindBitForBit) {
  const v1::AddObject message = parse(
      effect("CONSTANT",
             "amplitude_N: 1 direction { x: 1.0001 } region: EFFECT_REGION_BOX point_m { x: 0.1 } "
             "size_m { x: 0.1 y: 0.2 z: 0.3 } fade_m: 0.01") +
      effect("SPRING_TO_POINT", kSpring +
                                    "point_m { y: -0.1 } damping_Ns_per_m: 2 limit_N: 3 reach_m: 0.1 release_m: 0.2 "
                                    "fade_m: 0.15 frame: EFFECT_FRAME_WORLD") +
      effect("SPRING_TO_LINE", kSpring + kAlongZ) + effect("SPRING_TO_PLANE", kSpring + kAlongZ) +
      effect("SPRING_TO_PATH", kSpring + kPath) + effect("GUIDE", kSpring + kPath + "reach_m: 0.02") +
      effect("FORBIDDEN_SIDE", kSpring + kAlongZ) + effect("TUBE", kSpring + kPath + "size_m { x: 0.02 }") +
      effect("VISCOSITY", "damping_Ns_per_m: 4 trigger: EFFECT_TRIGGER_TOUCH") +
      effect("INERTIA", kSpring + "mass_kg: 0.1 region: EFFECT_REGION_INSIDE fade_m: 0.01") +
      effect("MAGNET", kSpring + "reach_m: 0.1") + effect("SPRING_TO_VERTEX", kSpring + "reach_m: 0.1") +
      effect("SPRING_TO_EDGE", kSpring + "reach_m: 0.1 limit_N: 2") +
      effect("SAMPLES", kAlongZ + "amplitude_N: 1 sample_rate_Hz: 8000 samples: [0, 0.1, -1]") +
      effect("RECORDED_TEXTURE", texture("0.1, 0.2", "0.5, 1.5", "1, -0.99, 0, 0.5, 0.1, 0.3, 0.4, 0") + "limit_N: 2") +
      effect("VIBRATION",
             kAlongZ + "amplitude_N: 1 frequency_Hz: 50 phase_rad: 1 region: EFFECT_REGION_SPHERE size_m { x: 1 }"));
  const auto asked = effectsFrom(message.effects());
  ASSERT_TRUE(asked) << asked.error().text();
  EXPECT_EQ((*asked)[0].direction, Vec3(1, 0, 0)) << "an edit's is normalised";
  EXPECT_EQ((*asked)[2].frame, Effect::Frame::kObject) << "by default";
  const auto announced = announcedEffectsFrom(message.effects());
  ASSERT_TRUE(announced);
  EXPECT_EQ((*announced)[0].direction, Vec3(1.0001, 0, 0)) << "a state's is hashed as it is";
  for (const auto& effects : {*asked, *announced}) {
    v1::ObjectState state;
    toWire(effects, *state.mutable_effects());
    const auto again = announcedEffectsFrom(state.effects());
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(*again, effects);
  }
}

/// As the Python and the JavaScript client compute it.
TEST(ConvertEffect, TheHashIsOverAllFieldsInOrder) {
  v1::ObjectState state;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(
      "id: 3 name: 'a' revision: 7 mesh: '01234567890123456789012345678901' pose { position { x: 1 } rotation { w: 1 } "
      "} "
      "stiffness_N_per_m: 100 damping_Ns_per_m: 1 color { red: 0.5 } "
      "effects { kind: EFFECT_KIND_GUIDE frame: EFFECT_FRAME_OBJECT region: EFFECT_REGION_EVERYWHERE "
      "path_m: [0, 0, 0.1, 0.1, -0.0, 0.1] stiffness_N_per_m: 100 reach_m: 0.01 trigger: EFFECT_TRIGGER_ALWAYS } "
      "effects { kind: EFFECT_KIND_VIBRATION frame: EFFECT_FRAME_WORLD direction { y: 1 } amplitude_N: 0.1 "
      "frequency_Hz: 50 phase_rad: -1 region: EFFECT_REGION_BOX point_m { x: 9 } size_m { x: 1 y: 2 z: 3 } fade_m: 0.1 "
      "trigger: EFFECT_TRIGGER_BUTTON } tap_Ns_per_m: 7.5 tap_Hz: 30 tap_decay_per_s: 80",
      &state));
  const auto record = fromWire(state);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(record->hash().hex(), "c65934a8b3da6fc3dc89e7d82f0c2298d5428817888804cfb6fff68881bd472f");
}

TEST(ConvertEffect, TheHashIsOverLaterFieldsWhereTheyAre) {
  v1::ObjectState state;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(
      "id: 3 name: 'a' revision: 7 mesh: '01234567890123456789012345678901' pose { position { x: 1 } rotation { w: 1 } "
      "} "
      "stiffness_N_per_m: 100 damping_Ns_per_m: 1 color { red: 0.5 } "
      "effects { kind: EFFECT_KIND_INERTIA frame: EFFECT_FRAME_OBJECT region: EFFECT_REGION_INSIDE "
      "stiffness_N_per_m: 100 mass_kg: 0.25 } "
      "effects { kind: EFFECT_KIND_SAMPLES frame: EFFECT_FRAME_OBJECT region: EFFECT_REGION_EVERYWHERE direction { y: "
      "1 } amplitude_N: 0.1 samples: [0.1, -0.0, -1] sample_rate_Hz: 8000 trigger: EFFECT_TRIGGER_BUTTON }",
      &state));
  const auto record = fromWire(state);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(record->hash().hex(), "26c2e1faed778b3d1e637da4e37764f76a084177f3339038bb0d4cb92c0c0700");
}

}  // namespace
}  // namespace haptics::convert_effect_test
