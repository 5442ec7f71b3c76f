#include <gtest/gtest.h>

#include "common/mesh/mesh_asset.h"
#include "tests/graphics_client/mirror/fake_server.h"

// A server in the client's process: its assets are held, not fetched.
namespace haptics::session_shared_assets_test {
namespace {

class SessionSharedAssets : public testing::Test {
 protected:
  void SetUp() override {
    rig_.server.addObject("a");
    for (const auto& [hash, bytes] : rig_.server.assets) {
      held_[hash] = std::make_shared<const TriMesh>(decodeMesh(bytes).value());
    }
  }

  void join() {
    rig_.connect();
    rig_.server.welcome(false);
    rig_.server.snapshot();
    rig_.settle();
  }

  [[nodiscard]] ContentHash mesh() const { return rig_.server.scene.objects()[0]->mesh; }
  [[nodiscard]] std::size_t requests() const { return rig_.server.heard(v1::Envelope::kAssetRequest).size(); }

  std::map<ContentHash, std::shared_ptr<const TriMesh>> held_;  // by the server
  SessionRig rig_{{.session = 77,
                   .clientName = "test",
                   .token = "",
                   .telemetryRate_Hz = 60,
                   .fetchAssets = true,
                   .sharedAssets = [this](const AssetName& name) -> std::optional<AssetContent> {
                     const auto at = held_.find(name.hash);
                     if (at == held_.end()) return std::nullopt;
                     return at->second;
                   }}};
};

TEST_F(SessionSharedAssets, AreTheServersOwnAndCheckedLikeAnyOther) {
  join();
  const MirrorView view = rig_.view();
  EXPECT_EQ(view.meshes.at(mesh()), held_.at(mesh()));
  EXPECT_TRUE(view.hashesEqual);
  EXPECT_EQ(recomputedRoot(view).value(), rig_.server.scene.root());
  EXPECT_EQ(requests(), 0U);
}

TEST_F(SessionSharedAssets, AreFetchedWhereTheServerDoesNotGiveThem) {
  held_.clear();
  join();
  EXPECT_EQ(requests(), 1U);
  rig_.server.asset(mesh());
  rig_.settle();
  EXPECT_TRUE(rig_.view().hashesEqual);
}

TEST_F(SessionSharedAssets, OfACommitAreHeldWithIt) {
  join();
  const v1::Commit commit = rig_.server.addObject("b");
  const ContentHash added = rig_.server.scene.objects()[1]->mesh;
  held_[added] = std::make_shared<const TriMesh>(decodeMesh(rig_.server.assets.at(added)).value());
  rig_.server.sendCommit(commit);
  rig_.settle();
  EXPECT_EQ(rig_.view().meshes.at(added), held_.at(added));
  EXPECT_TRUE(rig_.view().hashesEqual);
  EXPECT_EQ(requests(), 0U);
}

TEST_F(SessionSharedAssets, AreNotTakenWithAnotherContentThanTheirName) {
  held_[mesh()] = std::make_shared<const TriMesh>(tetrahedron(123));
  join();
  EXPECT_EQ(rig_.view().resyncs, 1U);
  EXPECT_TRUE(rig_.view().meshes.empty());
  EXPECT_FALSE(rig_.view().hashesEqual);
}

TEST_F(SessionSharedAssets, StayTheSameOverAReconnect) {
  join();
  rig_.cut();
  rig_.connect();
  rig_.server.welcome(true);
  rig_.settle();
  EXPECT_EQ(rig_.view().meshes.at(mesh()), held_.at(mesh()));
  EXPECT_EQ(requests(), 0U);
}

TEST_F(SessionSharedAssets, AreFreedOnceNeitherSideUsesThem) {
  join();
  const std::weak_ptr<const TriMesh> first = held_.at(mesh());
  ObjectRecord record = *rig_.server.scene.find(1);
  held_.clear();
  EXPECT_FALSE(first.expired()) << "the client still uses it";
  record.mesh = rig_.server.addMesh(tetrahedron(50));
  rig_.server.sendCommit(rig_.server.change(record));
  rig_.settle();
  EXPECT_TRUE(first.expired());
}

}  // namespace
}  // namespace haptics::session_shared_assets_test
