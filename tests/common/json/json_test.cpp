#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "common/json/message_json.h"
#include "haptics/v1/envelope.pb.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics::json_test {
namespace {

nlohmann::json parsed(const google::protobuf::Message& message) {
  return nlohmann::json::parse(toJson(message).line());
}

TEST(Json, WritesMembersAndElementsInTheirOrder) {
  Json summary = {{"ticks", 3}, {"fifo", true}, {"latency", {{"p50", 1.5}, {"p99", -2}}}, {"none", Json::array()}};
  summary.set("axis", Json::array({0.25, 1, "z"}));
  EXPECT_EQ(summary.line(), R"({"ticks":3,"fifo":true,"latency":{"p50":1.5,"p99":-2},"none":[],"axis":[0.25,1,"z"]})");
  EXPECT_EQ(Json({{"a", Json{}}}).indented(), "{\n  \"a\": {}\n}");
}

TEST(Json, WritesNothingThatATerminalOrAReaderTripsOver) {
  EXPECT_EQ(Json("a\"\n\x1b\u00b5\xff").line(), R"("a\"\n\u001b\u00b5\ufffd")");
  EXPECT_EQ(Json(std::numeric_limits<double>::quiet_NaN()).line(), "null");
}

TEST(MessageJson, KeepsWholeNumbersWhole) {
  v1::EditLive live;
  live.set_tick((1ULL << 63U) + 1);
  EXPECT_EQ(toJson(live).line(), R"({"client_seq":0,"revision":0,"tick":9223372036854775809})");
}

TEST(MessageJson, WritesListsOfNumbers) {
  v1::Lattice lattice;
  for (const float metres : {0.5F, -0.25F}) lattice.add_control_m(metres);
  EXPECT_EQ(parsed(lattice)["control_m"], nlohmann::json::parse("[0.5, -0.25]"));
  v1::Effect effect;
  effect.add_path_m(0.125);
  EXPECT_EQ(parsed(effect)["path_m"], nlohmann::json::parse("[0.125]"));
}

TEST(MessageJson, WritesBytesAsHexadecimal) {
  v1::AssetUnavailable message;
  message.set_hash(std::string("\x00\x7f\xff\xa0", 4));
  EXPECT_EQ(parsed(message)["hash"], "007fffa0");
}

TEST(MessageJson, NamesEnumsAndNestsMessages) {
  v1::Telemetry sample;
  sample.set_fault(v1::FAULT_DEVICE_LOST);
  sample.mutable_force()->mutable_written()->set_z(1.5);
  const auto json = parsed(sample);
  EXPECT_EQ(json["fault"], "FAULT_DEVICE_LOST");
  EXPECT_EQ(json["force"]["written"]["z"], 1.5);
}

TEST(MessageJson, LeavesAbsentMessagesAndUnchosenAlternativesOut) {
  v1::EditReply reply;
  reply.mutable_rejected()->set_field("operations[0]");
  const auto json = parsed(reply);
  EXPECT_TRUE(json.contains("rejected"));
  EXPECT_FALSE(json.contains("accepted"));
  EXPECT_FALSE(parsed(v1::Telemetry{}).contains("hip"));
}

TEST(MessageJson, KeepsTheOrderAndTheEmptinessOfLists) {
  v1::Accepted accepted;
  EXPECT_EQ(parsed(accepted)["report"].dump(), "[]");
  accepted.add_report("first");
  accepted.add_report("second");
  accepted.add_object()->set_name("ball");
  EXPECT_THAT(parsed(accepted)["report"], testing::ElementsAre("first", "second"));
  EXPECT_EQ(parsed(accepted)["object"][0]["name"], "ball");
  v1::Commit commit;
  commit.add_removed(7);
  EXPECT_EQ(parsed(commit)["removed"].dump(), "[7]");
}

}  // namespace
}  // namespace haptics::json_test
