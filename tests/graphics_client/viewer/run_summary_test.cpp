#include "graphics_client/viewer/run_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/mesh/generators.h"
#include "tests/common/temporary_folder.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics::run_summary_test {
namespace {

using testing::HasSubstr;

nlohmann::json parsed(const RunSummary& summary) { return nlohmann::json::parse(summary.json()); }

TEST(Percentile, IsTheSmallestValueThatTheShareDoesNotExceed) {
  EXPECT_EQ(percentile({}, 0.5), 0);
  EXPECT_EQ(percentile({3}, 0), 3);
  EXPECT_EQ(percentile({3}, 1), 3);
  EXPECT_EQ(percentile({4, 1, 3, 2}, 0.5), 2);
  EXPECT_EQ(percentile({4, 1, 3, 2}, 0.51), 3);
  std::vector<double> hundred;
  for (int i = 100; i >= 1; --i) hundred.push_back(i);
  EXPECT_EQ(percentile(hundred, 0.99), 99);
  EXPECT_EQ(percentile(hundred, 1), 100);
}

TEST(RunSummary, OfNoFramesHasAllKeys) {
  const nlohmann::json json = parsed(RunSummary());
  EXPECT_EQ(json.at("viewer_frames"), 0);
  EXPECT_EQ(json.at("fps"), 0.0);
  EXPECT_EQ(json.at("hashes_equal"), false);
  EXPECT_EQ(json.at("client_scene_hash"), "");
  EXPECT_EQ(json.at("scene_revision"), 0);
  EXPECT_EQ(json.at("telemetry_age_ms").at("p99"), 0.0);
  EXPECT_EQ(json.at("resyncs"), 0);
  EXPECT_EQ(json.at("state_resets"), 0);
}

struct WithScene : testing::Test {
  FakeMirror mirror;
  RunSummary summary;

  WithScene() { mirror.touch(mirror.add("box", makeBox({0.1, 0.1, 0.1}, 1).value(), {}, {}), 0, 0.001); }
};

TEST_F(WithScene, FramesPerSecondAreCountedBetweenTheFirstAndTheLast) {
  for (int i = 0; i <= 20; ++i) summary.addFrame(mirror.now(), 0.01, 5 + 0.05 * i);
  EXPECT_EQ(parsed(summary).at("viewer_frames"), 21);
  EXPECT_NEAR(parsed(summary).at("fps").get<double>(), 20, 1e-9);
}

TEST_F(WithScene, BodiesAreToldAndHowFarTheShownContactIsFromTheShownSurface) {
  mirror.setMotion(1, MotionProperties{.mass_kg = 1});
  mirror.view().bodies[1] = {1, Pose{}, BodyCondition::kAsleep};
  summary.addFrame(mirror.now(), 0.01, 1);
  summary.addContact(*mirror.now());
  EXPECT_EQ(parsed(summary).at("client_bodies").at(0).at("condition"), "asleep");
  EXPECT_NEAR(parsed(summary).at("contact_error_mm").at("p99").get<double>(), 0, 1e-6);
  mirror.view().bodies[1].pose.position = 0.002 * mirror.view().sample->surfaceNormal;
  summary.addContact(*mirror.now());
  EXPECT_NEAR(parsed(summary).at("contact_error_mm").at("p99").get<double>(), 2, 1e-6);
}

TEST_F(WithScene, AgesAreInMillisecondsAndOnlyOfLiveFrames) {
  for (int i = 1; i <= 100; ++i) summary.addFrame(mirror.now(), 1e-3 * i, i);
  mirror.view().link = LinkState::kConnecting;
  summary.addFrame(mirror.now(), 60, 101);
  EXPECT_NEAR(parsed(summary).at("telemetry_age_ms").at("p50").get<double>(), 50, 1e-9);
  EXPECT_NEAR(parsed(summary).at("telemetry_age_ms").at("p99").get<double>(), 99, 1e-9);
}

TEST_F(WithScene, TheNewestAgesReplaceTheOldest) {
  for (std::size_t i = 0; i < RunSummary::kAgesKept; ++i) summary.addFrame(mirror.now(), 1, 0);
  for (std::size_t i = 0; i < RunSummary::kAgesKept; ++i) summary.addFrame(mirror.now(), 0.002, 0);
  EXPECT_NEAR(parsed(summary).at("telemetry_age_ms").at("p99").get<double>(), 2, 1e-9);
}

TEST_F(WithScene, TheHashIsOfTheSceneThatWasHeldWhileTheLinkWasLive) {
  summary.addFrame(mirror.now(), 0.01, 0);
  const std::string hash = mirror.view().scene->root().hex();
  mirror.view().link = LinkState::kConnecting;
  mirror.view().hashesEqual = false;
  mirror.view().resyncs = 2;
  mirror.view().stateResets = 1;
  summary.addFrame(mirror.now(), 0.01, 1);
  const nlohmann::json json = parsed(summary);
  EXPECT_EQ(json.at("client_scene_hash"), hash);
  EXPECT_EQ(json.at("hashes_equal"), true);
  EXPECT_EQ(json.at("scene_revision"), 1);
  EXPECT_EQ(json.at("resyncs"), 2);
  EXPECT_EQ(json.at("state_resets"), 1);
}

TEST_F(WithScene, ACorruptedMeshIsNotEqual) {
  auto& [hash, mesh] = *mirror.view().meshes.begin();
  TriMesh damaged = *mesh;
  damaged.vertices[0].x += 1e-3F;
  mesh = std::make_shared<const TriMesh>(damaged);
  summary.addFrame(mirror.now(), 0.01, 0);
  EXPECT_EQ(parsed(summary).at("hashes_equal"), false);
}

TEST_F(WithScene, AMissingMeshIsNotEqual) {
  mirror.view().meshes.clear();
  summary.addFrame(mirror.now(), 0.01, 0);
  EXPECT_EQ(parsed(summary).at("hashes_equal"), false);
  EXPECT_EQ(parsed(summary).at("client_scene_hash"), "");
}

}  // namespace
}  // namespace haptics::run_summary_test
