#include "graphics_client/mirror/session_follower.h"

#include <string>
#include <vector>

#include "tests/graphics_client/mirror/session_join_fixture.h"

// Who follows what a session takes, and a session that goes on from what was held before.
namespace haptics::session_follower_test {
namespace {

class SessionFollowed : public testing::Test {
 protected:
  ClientSession::Options options(std::optional<HeldScene> held = {}) {
    return {
        .session = 77,
        .clientName = "test",
        .token = "",
        .telemetryRate_Hz = 60,
        .fetchAssets = true,
        .follower = {
            .welcomed = [this](const v1::Welcome&) { heard_.push_back("welcome"); },
            .snapshot =
                [this](const SceneVersion& scene) { heard_.push_back("snapshot " + std::to_string(scene.revision())); },
            .commit =
                [this](const v1::Commit& commit, const SceneVersion& after) {
                  EXPECT_EQ(commit.root(), after.root().asBytes());
                  heard_.push_back("commit " + std::to_string(after.revision()));
                },
            .telemetry =
                [this](const v1::Telemetry& sample) { heard_.push_back("tick " + std::to_string(sample.tick())); }},
        .held = std::move(held)};
  }

  std::vector<std::string> heard_;
};

TEST_F(SessionFollowed, AllThatWasCheckedIsHeardInOrder) {
  SessionRig rig(options());
  rig.server.addObject("a");
  rig.join();
  rig.server.sendCommit(rig.server.addObject("b"));
  rig.server.telemetry(5);
  rig.settle();
  EXPECT_EQ(heard_, (std::vector<std::string>{"welcome", "snapshot 1", "commit 2", "tick 5"}));
}

TEST_F(SessionFollowed, ACommitThatLeadsToAnotherRootIsNotHeard) {
  SessionRig rig(options());
  rig.server.addObject("a");
  rig.join();
  v1::Commit forged = rig.server.addObject("b");
  forged.mutable_put(0)->set_stiffness_n_per_m(1);
  rig.server.sendCommit(forged);
  rig.settle();
  EXPECT_EQ(heard_, (std::vector<std::string>{"welcome", "snapshot 1"}));
}

TEST_F(SessionFollowed, ResumesWithWhatWasHeld) {
  FakeServer before;
  before.addObject("a");
  SessionRig rig(options(HeldScene{before.epoch, before.scene}));
  rig.server.addObject("a");
  rig.connect();
  const v1::Hello hello = rig.server.heard(v1::Envelope::kHello).at(0).hello();
  EXPECT_EQ(hello.epoch(), before.epoch);
  EXPECT_EQ(hello.revision(), 1U);
  EXPECT_EQ(hello.root(), before.scene.root().asBytes());
  const v1::Commit commit = rig.server.addObject("b");
  rig.server.welcome(true);
  rig.server.sendCommit(commit);
  rig.settle();
  EXPECT_EQ(heard_, (std::vector<std::string>{"welcome", "commit 2"}));
  EXPECT_EQ(rig.view().scene->root(), rig.server.scene.root());
}

}  // namespace
}  // namespace haptics::session_follower_test
