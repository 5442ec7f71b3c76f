#include "haptic_server/scene/surface_warnings.h"

#include <gmock/gmock.h>

#include "common/mesh/generators.h"
#include "common/surface/fourier_field.h"
#include "haptic_server/scene/effect_limits.h"

namespace haptics::surface_warnings_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A grating of 3 mm on a box with edges of 1 mm.
struct GratedBox {
  explicit GratedBox(double amplitude_m) {
    const FourierFamily grating{{{1, Vec3(1, 0, 0), 3e-3, 0}}};
    record.material.stiffness_N_per_m = 800;
    record.material.surface.texture.emplace();
    record.material.surface.texture->family = grating;
    record.material.surface.texture->amplitude_m = amplitude_m;
    assets.mesh = store.intern(makeBox(Vec3(0.02), 20).value());
    assets.textureField = std::make_shared<FourierField>(grating);
  }
  AssetStore store;
  ObjectRecord record;
  ObjectAssets assets;
};

TEST(SurfaceWarnings, SayNothingOfATextureThatIsFeltAsItWasAskedFor) {
  const GratedBox box(1e-4);
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {55e-6, 1000}), IsEmpty());
}

TEST(SurfaceWarnings, TellOfPitsThatAreFeltAsBumps) {
  GratedBox box(1e-4);
  Texture& texture = *box.record.material.surface.texture;
  texture.literal = true;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {55e-6, 1000}), ElementsAre(HasSubstr("felt as a bump")));
  texture.law = Texture::Law::kBump;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {55e-6, 1000}), IsEmpty());
}

TEST(SurfaceWarnings, TellOfAGainThatIsClampedForTheDevice) {
  const GratedBox box(5e-4);  // 9/8 (0.5 mm 2 pi / 3 mm)^2 = 1.234; 1.5 * 800 * 1.234 = 1480 N/m
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {55e-6, 988}),
              ElementsAre(AllOf(HasSubstr("gain_K is felt as 1.001 instead of 1.5"), HasSubstr("1480 N/m"))));
  GratedBox bump(5e-4);
  bump.record.material.surface.texture->law = Texture::Law::kBump;
  // (0.5 mm q)^2 + 1 / 800 * 0.5 mm q^2 = 1.097 + 2.742 of q = 2 pi / 3 mm; times 800 N/m: 3071 N/m
  EXPECT_THAT(surfaceWarnings(bump.record, bump.assets, {55e-6, 988}),
              ElementsAre(AllOf(HasSubstr("slopes are felt as 32.1"), HasSubstr("of 307"))));
  EXPECT_THAT(surfaceWarnings(bump.record, bump.assets, {55e-6, 4000}), IsEmpty());
}

TEST(SurfaceWarnings, TellOfADampingThatIsClampedForTheDevice) {
  GratedBox box(1e-4);
  box.record.material.damping_Ns_per_m = 30;
  const DeviceLimits device{.encoderStep_m = 55e-6, .maxDamping_Ns_per_m = 12};
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, device),
              ElementsAre(HasSubstr("damping_Ns_per_m is felt as 12 instead of 30")));
  box.record.material.damping_Ns_per_m = 12;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, device), IsEmpty());
}

TEST(SurfaceWarnings, TellOfATapThatIsNotFeltAsAskedFor) {
  GratedBox box(1e-4);
  SurfaceScalars<double>& scalars = box.record.material.surface.scalars;
  const auto warnings = [&] { return surfaceWarnings(box.record, box.assets, {55e-6, 1000}); };
  scalars.tap_Hz = 30;
  EXPECT_THAT(warnings(), IsEmpty()) << "there is none";
  scalars.tap_Ns_per_m = 7.5;
  scalars.tap_decay_per_s = 80;
  EXPECT_THAT(warnings(), IsEmpty());
  scalars.tap_decay_per_s = 20;
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("tap_decay_per_s is felt as 60 instead of 20")));
  scalars.tap_Hz = 0;
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("is not felt: tap_Hz is 0")));
}

TEST(SurfaceWarnings, TellOfAVibrationThatTheServoIsTooSlowFor) {
  ObjectRecord record;
  record.effects = {{.kind = Effect::Kind::kVibration, .amplitude_N = 1, .frequency_Hz = 500}};
  const auto warnings = [&](double period_s) {
    EffectZones zones;
    zones.add(record);
    return effectWarnings(record, {}, zones, {.period_s = period_s});
  };
  EXPECT_THAT(warnings(1e-3), ElementsAre(HasSubstr("500 Hz is not felt")));
  EXPECT_THAT(warnings(2.5e-4), IsEmpty());
  record.effects[0].frequency_Hz = 499;
  EXPECT_THAT(warnings(1e-3), IsEmpty());
}

TEST(SurfaceWarnings, TellOfEffectsThatNobodyNotices) {
  const Effect snap{.kind = Effect::Kind::kSpringToPoint, .stiffness_N_per_m = 100, .reach_m = 3e-4};
  Effect released = snap, damped = snap, limited = snap;
  released.release_m = 6e-4;
  damped.damping_Ns_per_m = 0.02;
  limited.reach_m = 0.1;
  limited.limit_N = 0.04;
  const Effect water{.kind = Effect::Kind::kViscosity, .damping_Ns_per_m = 0.02},
      honey{.kind = Effect::Kind::kViscosity, .damping_Ns_per_m = 0.03};
  ObjectRecord record;
  record.effects = {snap, released, damped, limited, water, honey};
  EffectZones zones;
  zones.add(record);
  EXPECT_THAT(
      effectWarnings(record, {}, zones, {}),
      ElementsAre(HasSubstr("effects[0] is not noticed: it pushes with 0.03 N"), HasSubstr("effects[3] is not noticed"),
                  HasSubstr("effects[4] is not noticed: it pushes with 0.04 N")));
}

TEST(SurfaceWarnings, TellOfAStiffnessThatIsClampedForTheDevice) {
  GratedBox box(1e-4);
  const DeviceLimits device{.encoderStep_m = 55e-6, .stiffest_N_per_m = 500};
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, device),
              ElementsAre(HasSubstr("stiffness_N_per_m is felt as 500 instead of 800")));
  box.record.material.stiffness_N_per_m = 500;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, device), IsEmpty());
}

TEST(SurfaceWarnings, TellOfAStiffnessByWhichOneStepOfTheEncoderIsFelt) {
  GratedBox box(1e-4);
  box.record.material.surface.texture.reset();
  const DeviceLimits device{.encoderStep_m = 50e-6, .stiffest_N_per_m = 20'000};
  box.record.material.stiffness_N_per_m = 5000;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, device), IsEmpty());
  box.record.material.stiffness_N_per_m = 20'000;
  EXPECT_THAT(
      surfaceWarnings(box.record, box.assets, device),
      ElementsAre(AllOf(HasSubstr("makes 1 N of one step"), HasSubstr("(0.05 mm)"), HasSubstr("up to 5000 N/m"))));
}

TEST(SurfaceWarnings, TellOfTheStiffestPlaceThatIsClampedForTheDevice) {
  GratedBox box(1e-4);
  box.record.material.surface.texture.reset();
  box.record.material.surface.stiffnessOver = SurfaceMap{.variation = 0.5, .over = FieldFamily{FourierFamily{}}};
  box.assets.stiffnessField = std::move(box.assets.textureField);
  const auto warnings = [&](double stiffest_N_per_m, double maxDamping_Ns_per_m) {
    return surfaceWarnings(
        box.record, box.assets,
        {.encoderStep_m = 55e-6, .stiffest_N_per_m = stiffest_N_per_m, .maxDamping_Ns_per_m = maxDamping_Ns_per_m});
  };
  EXPECT_THAT(warnings(1200, 0.75), IsEmpty());
  EXPECT_THAT(warnings(1000, 1),
              ElementsAre(AllOf(HasSubstr("is felt as 1000 instead of 1200, its most by stiffness_over"))));
  EXPECT_THAT(warnings(1200, 0.6),
              ElementsAre(HasSubstr("damping_Ns_per_m is felt as 0.6 instead of 0.75, its most by")));
}

TEST(SurfaceWarnings, TellOfAMapOfStiffnessOrSoftnessFinerThanTheEncoder) {
  GratedBox box(1e-4);
  box.record.material.stiffness_N_per_m = 100;
  box.record.material.surface.texture.reset();
  box.record.material.surface.stiffnessOver = SurfaceMap{.variation = 0.1, .over = FieldFamily{FourierFamily{}}};
  box.assets.stiffnessField = box.assets.textureField;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {2e-3, 3000}),
              ElementsAre(AllOf(HasSubstr("stiffness_over's finest detail, 3 mm"), HasSubstr("encoder"))));
  std::swap(box.record.material.surface.stiffnessOver, box.record.material.surface.softnessOver);
  box.assets.softnessField = std::move(box.assets.stiffnessField);
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {2e-3, 3000}), IsEmpty()) << "a rigid object has no softness";
  box.record.deformation.softness = Softness{.stiffness_N_per_m = 500, .radius_m = 0.01};
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {2e-3, 3000}),
              ElementsAre(HasSubstr("softness_over's finest detail, 3 mm")));
}

TEST(SurfaceWarnings, TellOfAMapThatWouldPushSidewaysMoreThanTheDeviceBears) {
  GratedBox box(1e-4);
  box.record.material.surface.texture.reset();
  box.record.material.surface.stiffnessOver = SurfaceMap{.variation = 0.5, .over = FieldFamily{FourierFamily{}}};
  box.assets.stiffnessField = std::move(box.assets.textureField);
  // 0.5 q^2 / (2 * 800 N/m) + 0.5 q of q = 2 pi / 3 mm: 1371 + 1047 N/m
  EXPECT_THAT(
      surfaceWarnings(box.record, box.assets, {55e-6, 1000}),
      ElementsAre(AllOf(HasSubstr("stiffness_over pushes sideways with 41.3"), HasSubstr("of up to 2418 N/m"))));
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {55e-6, 2500}), IsEmpty());
}

TEST(SurfaceWarnings, TellOfAWaveOfTheDynamicCoefficientFinerThanTheEncoder) {
  GratedBox box(1e-4);
  box.record.material.stiffness_N_per_m = 100;
  box.record.material.surface.texture.reset();
  box.record.material.surface.friction = Friction{.mu_static = 1, .mu_dynamic = 0.5, .dynamicVariation = 0.5};
  box.assets.dynamicFrictionField = std::move(box.assets.textureField);
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {2e-3, 1000}),
              ElementsAre(AllOf(HasSubstr("dynamic friction's finest detail, 3 mm"), HasSubstr("encoder"))));
}

TEST(MotionWarnings, TellWhatAToolOfManyPointsTakes) {
  GratedBox box(1e-4);  // of 20 mm
  box.assets.mesh = box.store.intern(makeBox(Vec3(0.02), 1).value());
  const auto warnings = [&](double spacing_m, double period_s) {
    box.record.motion = MotionProperties{.tool = ToolProperties{spacing_m}};
    return motionWarnings(box.record, box.assets, {.period_s = period_s});
  };
  EXPECT_THAT(warnings(0.001, 1e-3), IsEmpty());
  EXPECT_THAT(warnings(0.0005, 1e-3),
              ElementsAre(AllOf(HasSubstr(" points; where they meet fine meshes they take some "),
                                HasSubstr(" us of a tick of 1000 us"), HasSubstr("has about 4000"))));
  EXPECT_THAT(warnings(0.001, 2.5e-4), ElementsAre(AllOf(HasSubstr("of a tick of 250 us"), HasSubstr("about 1000"))))
      << "a quarter of the time";
}

TEST(MotionWarnings, TellHowFarAVertexOfAFineToolIsFromAPoint) {
  ObjectRecord record;
  record.motion = MotionProperties{.tool = ToolProperties{0.004}};
  ObjectAssets assets;
  AssetStore store;
  assets.mesh = store.intern(makeTorus(0.02, 0.008, 128, 48).value());
  EXPECT_THAT(motionWarnings(record, assets, {.period_s = 1e-3}),
              ElementsAre(AllOf(HasSubstr("one is up to 2.56 mm from the nearest of the "),
                                HasSubstr("so deep in what the tool touches"))));
}

TEST(SurfaceWarnings, TellOfAWaveFinerThanTheEncoderOrTheMesh) {
  GratedBox box(1e-4);
  box.record.material.stiffness_N_per_m = 100;
  EXPECT_THAT(surfaceWarnings(box.record, box.assets, {2e-3, 1000}), ElementsAre(HasSubstr("encoder")));
}

}  // namespace
}  // namespace haptics::surface_warnings_test
