#include "haptic_server/device/plugin/vendors/haply_message.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace haptics::test::haply_message_test {
namespace {

// As the service's pages have it, shortened.
const std::string kMessage = R"({"session_id": 7, "inverse3": [
  {"device_id": "0001", "state": {"cursor_position": {"x": 9, "y": 9, "z": 9}, "current_cursor_force": {"x": 0, "y": 0, "z": 0}}},
  {"device_id": "049D", "config": {"type": "inverse3"},
   "state": {"cursor_position": {"x": 0.01, "y": -0.12, "z": 0.15}, "cursor_velocity": {"x": 0.1, "y": 0.2, "z": -0.3},
             "current_cursor_force": {"x": 1, "y": 2, "z": -3}, "control_mode": "idle"},
   "status": {"calibrated": true, "in_use": false, "power_supply": true, "ready": true, "started": true}}],
  "verse_grip": [],
  "wireless_verse_grip": [{"device_id": "61548", "state": {"orientation": {"w": 0.8, "x": 0.6, "y": 0, "z": 0},
                                                           "buttons": {"a": true, "b": false, "c": true}}}]})";

std::optional<HaplyMessage> parse(const std::string& text, std::string_view wanted = "") {
  std::string reason;
  auto said = parseHaply(text, wanted, reason);
  EXPECT_EQ(said.has_value(), reason.empty());
  return said;
}
std::string refusalOf(const std::string& text, std::string_view wanted = "") {
  std::string reason;
  EXPECT_FALSE(parseHaply(text, wanted, reason));
  return reason;
}
/// The message with one of its parts replaced.
std::string with(const std::string& part, const std::string& other) {
  std::string text = kMessage;
  return text.replace(text.find(part), part.size(), other);
}

TEST(HaplyMessage, HasTheWantedDevicesNumbersInTheServersFrameAndUnits) {
  const auto said = parse(kMessage, "049D");
  ASSERT_TRUE(said);
  EXPECT_EQ(said->id, "049D");
  EXPECT_EQ(said->position, Vec3(0.01, -0.12, 0.15));
  EXPECT_EQ(said->appliedForce_N, Vec3(1, 2, -3));
  EXPECT_EQ(said->velocity, Vec3(0.1, 0.2, -0.3));
  EXPECT_EQ(said->rotation, Quat(0.8, 0.6, 0, 0));
  EXPECT_EQ(said->buttons, 0b101U);
  EXPECT_EQ(said->isCalibrated, true);
  EXPECT_EQ(said->isInUse, false);
  EXPECT_EQ(said->isPowered, true);
}

TEST(HaplyMessage, IsTheFirstDevicesWhereNoneIsWanted) {
  const auto said = parse(kMessage);
  ASSERT_TRUE(said);
  EXPECT_EQ(said->id, "0001");
  EXPECT_EQ(said->velocity, std::nullopt);
  EXPECT_EQ(said->isCalibrated, std::nullopt);
}

TEST(HaplyMessage, AGripWithOneButtonIsTheFirst) {
  const auto said = parse(with(R"("verse_grip": [],)", R"("verse_grip": [{"device_id": "1", "state":
      {"orientation": {"w": 1, "x": 0, "y": 0, "z": 0}, "button": true, "hall": 3}}],)"));
  ASSERT_TRUE(said);
  EXPECT_EQ(said->rotation, Quat(1, 0, 0, 0));
  EXPECT_EQ(said->buttons, 1U);
}

TEST(HaplyMessage, WhatIsNoneIsRefusedWithAReason) {
  EXPECT_EQ(refusalOf(kMessage.substr(0, 400)), "its service sends what is no JSON");
  EXPECT_EQ(refusalOf(""), "its service sends what is no JSON");
  EXPECT_EQ(refusalOf(kMessage, "1234"), "its service has no such Inverse3");
  for (const char* const text : {"[]", "3", "null", "{}", R"({"inverse3": 5})", R"({"inverse3": []})",
                                 R"({"inverse3": [3]})", R"({"inverse3": [{"device_id": 5}]})"})
    EXPECT_EQ(refusalOf(text), "its service has no such Inverse3") << text;
  for (const char* const value : {"null", "\"0.15\"", "[]", "{}", "true"}) {
    EXPECT_EQ(refusalOf(with("0.15", value), "049D"), "its service tells no cursor_position") << value;
    EXPECT_EQ(refusalOf(with("-3", value), "049D"), "its service tells no current_cursor_force") << value;
  }
}

TEST(HaplyMessage, AnyDamageIsRefusedOrRead) {
  std::mt19937 random(57);
  for (int i = 0; i < 20'000; ++i) {
    std::string text = kMessage;
    for (std::uint32_t damages = 1 + random() % 3; damages > 0; --damages) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0)
        text[at] = static_cast<char>(random());
      else
        text.erase(at, 1 + random() % 40);
      if (text.empty()) break;
    }
    (void)parse(text, i % 2 == 0 ? "049D" : "");
  }
}

TEST(HaplyMessage, NestedWithoutEndIsRefused) {
  EXPECT_EQ(refusalOf(std::string(60'000, '[')), "its service sends what is no JSON");
  EXPECT_EQ(refusalOf(std::string(30'000, '[') + std::string(30'000, ']')), "its service has no such Inverse3");
}

TEST(HaplyMessage, ACommandIsSpelledEitherWay) {
  EXPECT_EQ(
      haplyCommand("049D", {0, -1, 1.5}, HaplySpelling::kVector, false),
      R"({"inverse3":[{"commands":{"set_cursor_force":{"vector":{"x":0.0,"y":-1.0,"z":1.5}}},"device_id":"049D"}]})");
  EXPECT_EQ(
      haplyCommand("049D", {0, -1, 1.5}, HaplySpelling::kValues, false),
      R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":0.0,"y":-1.0,"z":1.5}}},"device_id":"049D"}]})");
}

TEST(HaplyMessage, TheFirstOneNamesTheSessionAndSetsOriginGateAndDamping) {
  const std::string first = haplyCommand("049D", Vec3(0), HaplySpelling::kVector, true);
  for (const char* const part :
       {R"("session":{"configure":{"profile":{"name":"haptic_server"}}})",
        R"("preset":{"preset":"arm_front_centered"})", R"("force_gate":{"gain":0.3})", R"("damping":{"scalar":0.0})"})
    EXPECT_NE(first.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace haptics::test::haply_message_test
