#include "graphics_client/viewer/overlay_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/mesh/generators.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics::overlay_text_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kFresh_s = 0.004;

OverlayLine find(const std::vector<OverlayLine>& lines, const std::string& label) {
  const auto at = std::ranges::find(lines, label, &OverlayLine::label);
  return at == lines.end() ? OverlayLine{.label = label, .value = "(no such line)"} : *at;
}

struct Touching : testing::Test {
  FakeMirror mirror;
  MirrorView& view = mirror.view();
  ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 1).value(), {}, {});

  Touching() { mirror.touch(box, 3, 0.0025); }
  [[nodiscard]] OverlayLine status(const std::string& label) const {
    return find(statusLines(view, kFresh_s, 59.6), label);
  }
  [[nodiscard]] OverlayLine contact(const std::string& label) const { return find(contactLines(view), label); }
};

TEST_F(Touching, StatusSaysRateAgeRevisionAndFrames) {
  view.sample->missedTicks = 17;
  EXPECT_EQ(status("Link"), (OverlayLine{"Link", "live", Tone::kGood}));
  EXPECT_EQ(status("Servo").value, "1000 Hz");
  EXPECT_EQ(status("Missed ticks").value, "17");
  EXPECT_EQ(status("Telemetry age").value, "4.0 ms");
  view.telemetryByDatagram = true;
  EXPECT_EQ(status("Telemetry age").value, "4.0 ms by UDP");
  EXPECT_EQ(status("Revision").value, "1, felt: 1");
  EXPECT_EQ(status("Objects").value, "1");
  EXPECT_EQ(status("Picture").value, "60 frames/s");
}

TEST_F(Touching, TheLegendHasTheColoursOfEffectsThatAreThere) {
  const auto labels = [&] {
    std::vector<std::string> all;
    for (const LegendRow& row : effectLegend(view)) all.push_back(row.line.label);
    return all;
  };
  EXPECT_THAT(labels(), IsEmpty());
  mirror.setEffects(box, {{.kind = Effect::Kind::kTube}, {.kind = Effect::Kind::kConstant}});
  EXPECT_THAT(labels(), testing::ElementsAre("Blocks", "Acts"));
  mirror.setEffects(box, {{.kind = Effect::Kind::kInertia}, {.kind = Effect::Kind::kMagnet}});
  EXPECT_THAT(labels(), testing::ElementsAre("Pulls", "Drags"));
}

TEST_F(Touching, APictureThatIsDrawnHardlyEverIsIdle) {
  EXPECT_EQ(find(statusLines(view, kFresh_s, 0.5), "Picture").value, "idle");
}

TEST_F(Touching, EveryLineSaysWhatItMeans) {
  view.sample->depenetrated = view.sample->allowanceSpent = 1;
  view.tool.emplace();
  view.secondHand = view.sample;
  for (const auto& lines : {statusLines(view, kFresh_s, 60), contactLines(view)}) {
    for (const OverlayLine& line : lines) EXPECT_NE(overlayTip(line.label), "") << line.label;
  }
}

TEST_F(Touching, DetailsAreLeftOutUnlessTheyWarn) {
  const auto shown = [&] { return withoutDetails(statusLines(view, kFresh_s, 60)); };
  EXPECT_EQ(find(shown(), "Link").value, "live");
  EXPECT_EQ(find(shown(), "Scene hash").value, "(no such line)");
  view.hashesEqual = false;
  EXPECT_THAT(find(shown(), "Scene hash").value, HasSubstr("NOT equal"));
}

TEST_F(Touching, WhatTheServerSaysOfItselfIsEscapedAndCutBetweenCharacters) {
  view.serverName = "a\x1b[2J\nb";
  view.device = "Gerat ääääääääääääääääääää";
  EXPECT_EQ(status("Server").value, R"(a\x1b[2J\x0ab)");
  EXPECT_EQ(status("Device").value, "Gerat ääääääää...");
  view.link = LinkState::kRefused;
  view.linkText = "refused by the server: \x1b]0;owned\x07 \u202e";
  EXPECT_EQ(bannerFor(view, kFresh_s, false, false).text, R"(refused by the server: \x1b]0;owned\x07 \u202e)");
  view.link = LinkState::kConnecting;
  EXPECT_THAT(bannerFor(view, kFresh_s, true, false).text, HasSubstr(R"(\x1b)"));
  EXPECT_THAT(bannerFor(view, kFresh_s, false, false).text, HasSubstr(R"(\x1b)"));
}

TEST_F(Touching, ADepenetratedIhipIsCountedAndTheBodyNamed) {
  EXPECT_EQ(status("IHIP depenetrated").value, "(no such line)");
  view.sample->depenetrated = 3;
  view.sample->depenetratedFrom = box;
  EXPECT_EQ(status("IHIP depenetrated"), (OverlayLine{"IHIP depenetrated", "3 times, last from box", Tone::kWarning}));
}

TEST_F(Touching, HashesAreSaidToBeEqualOnlyWhenTheyAreAndTheLinkIsLive) {
  EXPECT_THAT(status("Scene hash").value, HasSubstr("equal"));
  EXPECT_EQ(status("Scene hash").tone, Tone::kGood);
  view.hashesEqual = false;
  EXPECT_THAT(status("Scene hash").value, HasSubstr("NOT equal"));
  EXPECT_EQ(status("Scene hash").tone, Tone::kBad);
  view.hashesEqual = true;
  view.link = LinkState::kConnecting;
  EXPECT_EQ(status("Scene hash").value, "not compared");
}

TEST_F(Touching, MissingMeshesAreCounted) {
  view.meshes.clear();
  EXPECT_EQ(status("Objects").value, "0 of 1 received");
  EXPECT_EQ(status("Objects").tone, Tone::kWarning);
}

TEST_F(Touching, BodiesThatMoveAreCountedAndThoseThatWereStoppedAreNamed) {
  view.bodies[box] = {box, Pose{}, BodyCondition::kAwake};
  EXPECT_EQ(status("Objects").value, "1, 1 moving");
  EXPECT_THAT(bannerFor(view, kFresh_s, true, false).text, IsEmpty());
  view.bodies[box].condition = BodyCondition::kOutOfBounds;
  EXPECT_EQ(status("Objects").value, "1, 0 moving");
  EXPECT_THAT(bannerFor(view, kFresh_s, true, false).text, HasSubstr("box left the world's bounds"));
  view.bodies[box].condition = BodyCondition::kNonFinite;
  EXPECT_THAT(bannerFor(view, kFresh_s, true, false).text, HasSubstr("not finite"));
}

TEST_F(Touching, FaultsReplaceTheServoRate) {
  view.sample->fault = Fault::kDeviceLost;
  EXPECT_THAT(status("Servo").value, HasSubstr("device lost"));
  EXPECT_EQ(status("Servo").tone, Tone::kBad);
}

TEST_F(Touching, TheDevicesOwnFaultReplacesItsName) {
  view.sample->device.fault = DeviceFault::kUnplugged;
  EXPECT_THAT(status("Device").value, HasSubstr("unplugged"));
  EXPECT_EQ(status("Device").tone, Tone::kBad);
}

TEST_F(Touching, ADeviceThatIsNotHomedAsksForIt) {
  view.sample->deviceState = DeviceState::kHoming;
  view.sample->fault = Fault::kDeviceLost;
  EXPECT_THAT(status("Device").value, HasSubstr("homed"));
  EXPECT_EQ(status("Device").tone, Tone::kWarning);
  EXPECT_EQ(status("Servo").value, "no force before homing");
}

TEST_F(Touching, LongNamesAreShortened) {
  view.serverName = std::string(64, 'm');
  EXPECT_LT(status("Server").value.size(), 30U);
  EXPECT_THAT(status("Server").value, HasSubstr("..."));
}

TEST_F(Touching, ContactSaysForceObjectAndPrimitive) {
  EXPECT_EQ(contact("Force").value, "2.00 N");
  EXPECT_EQ(contact("Contact").value, "box");
  EXPECT_EQ(contact("On").value, "polygon 3");
  EXPECT_EQ(contact("Penetration").value, "2.50 mm");
  view.sample->primitive = {PrimitiveKind::kLine, 2, 5};
  EXPECT_EQ(contact("On").value, "line 2 of polygon 5");
  view.sample->primitive = {PrimitiveKind::kVertex, 1, 5};
  EXPECT_EQ(contact("On").value, "vertex 1 of polygon 5");
}

TEST_F(Touching, ContactSaysTheTorqueOfAToolAndWhatTheDeviceGivesOfIt) {
  EXPECT_EQ(contact("Torque").value, "(no such line)");
  view.tool = ToolState{.object = box, .torque_Nm = {0, 0.012, 0}, .point = {}};
  EXPECT_EQ(contact("Torque").value, "12.0 mNm");
  view.tool->written_Nm = {0, 0.0095, 0};
  EXPECT_EQ(contact("Torque").value, "12.0 mNm, 9.5 given");
  EXPECT_EQ(contact("Jaws").value, "(no such line)");
  view.tool->grip = ToolState::Grip{.opening_rad = 0.25, .moment_Nm = 0.03};
  EXPECT_EQ(contact("Jaws").value, "14.3 deg");
  EXPECT_EQ(contact("Grip").value, "30.0 mNm");
  view.tool->grip->written_Nm = 0.02;
  EXPECT_EQ(contact("Grip").value, "30.0 mNm, 20.0 given");
}

TEST_F(Touching, ContactSaysWhatTheHandDoesWithTheHandleWhereThatIsMeasured) {
  EXPECT_EQ(contact("Handle").value, "(no such line)");
  view.sample->device.buttons = 0b101;
  EXPECT_EQ(contact("Handle").value, "button 0, button 2");
  view.sample->device.buttons = 0;
  view.sample->handle = {{0.03, 0, 0.04}, {0, 0, 2}, 0.5, HandleReading::kAll};
  EXPECT_EQ(contact("Handle").value, "gripper 28.6 deg, 50 mm/s, applies 2.00 N");
  view.sample->device.set(HandAction::kClutch, true);
  EXPECT_EQ(contact("Handle").value, "clutched, gripper 28.6 deg, 50 mm/s, applies 2.00 N");
}

TEST_F(Touching, ContactWithAnObjectThatIsNotKnownYetGivesItsNumber) {
  view.sample->object = 99;
  EXPECT_EQ(contact("Contact").value, "object 99");
}

TEST_F(Touching, AForceAtTheLimitIsMarked) {
  EXPECT_EQ(contact("Force").tone, Tone::kPlain);
  view.maxForce_N = 2.0;
  EXPECT_THAT(contact("Force").value, HasSubstr("limit"));
  EXPECT_EQ(contact("Force").tone, Tone::kWarning);
}

TEST_F(Touching, ContactSaysWhetherItSticksAndHowHighTheTextureIs) {
  EXPECT_EQ(contact("Friction").value, "-");
  EXPECT_EQ(contact("Texture").value, "-");
  view.sample->frictionState = FrictionState::kSticking;
  view.sample->force.friction = {0.3, 0.4, 0};
  EXPECT_EQ(contact("Friction").value, "sticking, 0.50 N");
  view.sample->frictionState = FrictionState::kSliding;
  EXPECT_EQ(contact("Friction").value, "sliding, 0.50 N");
  SurfaceProperties surface;
  surface.texture = Texture{.family = NoiseFamily{.wavelength_m = 0.01}, .amplitude_m = 0.0005};
  mirror.setSurface(box, surface);
  view.sample->height_m = -0.00012;
  view.sample->force.texture = {0, 0, 0.25};
  EXPECT_EQ(contact("Texture").value, "-0.12 mm, 0.25 N");
}

TEST_F(Touching, StatusSaysWherePitsAreFeltAsBumps) {
  EXPECT_EQ(find(statusLines(view, kFresh_s, 60, {}, true), "Surfaces"),
            (OverlayLine{"Surfaces", "pits drawn, felt as bumps", Tone::kWarning}));
}

TEST_F(Touching, StatusSaysWhereSurfacesAreDrawnCoarserThanFelt) {
  EXPECT_EQ(status("Surfaces").value, "drawn as felt");
  const CoarseDetail coarse{.object = "sandpaper", .detail_m = 0.0003, .edge_m = 0.00041};
  const OverlayLine line = find(statusLines(view, kFresh_s, 60, coarse), "Surfaces");
  EXPECT_EQ(line, (OverlayLine{"Surfaces", "felt 0.3, drawn 0.41 mm", Tone::kWarning}));
}

TEST_F(Touching, TheCardsKeepTheirShapeWhateverIsKnown) {
  const auto labels = [](const std::vector<OverlayLine>& lines) {
    std::vector<std::string> names;
    names.reserve(lines.size());
    for (const OverlayLine& line : lines) names.push_back(line.label);
    return names;
  };
  const MirrorView nothing;
  EXPECT_EQ(labels(statusLines(nothing, 0, 0)), labels(statusLines(view, kFresh_s, 60)));
  EXPECT_EQ(labels(contactLines(nothing)), labels(contactLines(view)));
}

TEST_F(Touching, ThePictureIsCurrentOnlyWithALiveLinkAndFreshTelemetry) {
  EXPECT_TRUE(isCurrent(view, kFresh_s));
  EXPECT_FALSE(isCurrent(view, 2 * kStaleTelemetry_s));
  view.link = LinkState::kConnecting;
  EXPECT_FALSE(isCurrent(view, kFresh_s));
}

TEST_F(Touching, TheBannerIsSilentWhenAllIsWell) {
  EXPECT_THAT(bannerFor(view, kFresh_s, true, false).text, IsEmpty());
}

TEST_F(Touching, TheBannerTellsLossFromFirstConnection) {
  view.link = LinkState::kConnecting;
  view.linkText = "connecting to 127.0.0.1:7654";
  const Banner first = bannerFor(view, kFresh_s, false, false), lost = bannerFor(view, kFresh_s, true, false);
  EXPECT_EQ(first, (Banner{view.linkText, Tone::kWarning}));
  EXPECT_THAT(lost.text, HasSubstr("LINK LOST"));
  EXPECT_THAT(lost.text, HasSubstr(view.linkText));
  EXPECT_EQ(lost.tone, Tone::kBad);
}

TEST_F(Touching, TheBannerTellsRefusalResetAndSilence) {
  EXPECT_THAT(bannerFor(view, kFresh_s, true, true).text, HasSubstr("reset"));
  EXPECT_THAT(bannerFor(view, 2 * kStaleTelemetry_s, true, false).text, HasSubstr("not current"));
  view.link = LinkState::kRefused;
  view.linkText = "protocol_version: 9 is not 1";
  EXPECT_THAT(bannerFor(view, kFresh_s, true, true).text, HasSubstr(view.linkText));
}

}  // namespace
}  // namespace haptics::overlay_text_test
