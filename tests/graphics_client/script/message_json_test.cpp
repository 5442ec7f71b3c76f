#include "graphics_client/script/message_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "haptics/v1/envelope.pb.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics::message_json_test {
namespace {

TEST(MessageJson, KeepsWholeNumbersWhole) {
  v1::EditLive live;
  live.set_tick((1ULL << 63U) + 1);
  EXPECT_EQ(toJson(live).dump(), R"({"client_seq":0,"revision":0,"tick":9223372036854775809})");
}

TEST(MessageJson, WritesBytesAsHexadecimal) {
  v1::AssetUnavailable message;
  message.set_hash(std::string("\x00\x7f\xff\xa0", 4));
  EXPECT_EQ(toJson(message)["hash"], "007fffa0");
}

TEST(MessageJson, NamesEnumsAndNestsMessages) {
  v1::Telemetry sample;
  sample.set_fault(v1::FAULT_DEVICE_LOST);
  sample.mutable_force()->mutable_written()->set_z(1.5);
  const auto json = toJson(sample);
  EXPECT_EQ(json["fault"], "FAULT_DEVICE_LOST");
  EXPECT_EQ(json["force"]["written"]["z"], 1.5);
}

TEST(MessageJson, LeavesAbsentMessagesAndUnchosenAlternativesOut) {
  v1::EditReply reply;
  reply.mutable_rejected()->set_field("operations[0]");
  const auto json = toJson(reply);
  EXPECT_TRUE(json.contains("rejected"));
  EXPECT_FALSE(json.contains("accepted"));
  EXPECT_FALSE(toJson(v1::Telemetry{}).contains("hip"));
}

TEST(MessageJson, KeepsTheOrderAndTheEmptinessOfLists) {
  v1::Accepted accepted;
  EXPECT_EQ(toJson(accepted)["report"].dump(), "[]");
  accepted.add_report("first");
  accepted.add_report("second");
  accepted.add_object()->set_name("ball");
  EXPECT_THAT(toJson(accepted)["report"], testing::ElementsAre("first", "second"));
  EXPECT_EQ(toJson(accepted)["object"][0]["name"], "ball");
  v1::Commit commit;
  commit.add_removed(7);
  EXPECT_EQ(toJson(commit)["removed"].dump(), "[7]");
}

}  // namespace
}  // namespace haptics::message_json_test
