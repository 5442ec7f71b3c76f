#include "graphics_client/embedded_server.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <future>

#include "tests/common/temporary_folder.h"

namespace haptics::embedded_server_test {
namespace {

constexpr std::chrono::seconds kPatience{60};
constexpr const char* kScene = R"(
operations { add { name: "ball" mesh { sphere { radius_m: 0.05 segments: 24 } } } }
operations {
  add {
    name: "rough"
    mesh { box { size_m { x: 0.1 y: 0.1 z: 0.1 } } }
    pose { position { x: 0.3 } }
    material {
      texture {
        amplitude_m: 0.0002
        field {
          mapped {
            reaction_diffusion { pattern: REACTION_DIFFUSION_PATTERN_SPOTS cells: 4 resolution: 64 }
            mapping { shape: MAPPING_SHAPE_PLANE tile_m: 0.02 }
          }
        }
      }
    }
  }
})";

class EmbeddedServerTest : public testing::Test {
 protected:
  EmbeddedServerTest() { setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1); }

  [[nodiscard]] ServerOptions optionsWith(const std::string& scene) const {
    ServerOptions options;
    options.recordings = folder_.path();
    options.scene = folder_ / "test.scene";
    std::ofstream(options.scene) << scene;
    return options;
  }

  [[nodiscard]] static std::unique_ptr<ServerLink> link(EmbeddedServer& server) {
    ServerLink::Options options;
    options.clientName = "test";
    options.connect = server.connect();
    options.sharedAssets = server.sharedAssets();
    return std::make_unique<ServerLink>(std::move(options));
  }

  [[nodiscard]] static std::shared_ptr<const MirrorView> inStep(const ServerLink& link, std::uint64_t revision) {
    return link.waitUntil(
        [revision](const MirrorView& view) { return view.hashesEqual && view.scene->revision() == revision; },
        kPatience);
  }

  /// Accepted, or why not.
  [[nodiscard]] static std::string apply(ServerLink& link, const v1::Transaction& transaction) {
    std::promise<std::string> outcome;
    link.submit(transaction, {[&](const v1::EditReply& reply) {
                                outcome.set_value(reply.has_accepted() ? "accepted" : reply.ShortDebugString());
                              },
                              {}});
    return outcome.get_future().get();
  }

  template <class Condition>
  [[nodiscard]] static bool eventually(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return condition();
  }

  const test::TemporaryFolder folder_;
};

TEST_F(EmbeddedServerTest, HoldsEachAssetOnceForServerAndViewer) {
  EmbeddedServer server(optionsWith(kScene), [] {});
  const auto viewer = link(server);
  const auto view = inStep(*viewer, 1);
  ASSERT_TRUE(view) << viewer->latest()->linkText;
  ASSERT_EQ(view->meshes.size(), 2U);
  ASSERT_EQ(view->fields.size(), 1U);
  const SharedAssets servers = server.sharedAssets();
  for (const auto& [hash, mesh] : view->meshes) {
    EXPECT_EQ(servers({AssetKind::kMesh, hash}), AssetContent(mesh));
  }
  for (const auto& [hash, field] : view->fields) {
    EXPECT_EQ(servers({AssetKind::kScalarField, hash}), AssetContent(field));
  }
  EXPECT_EQ(recomputedRoot(*view).value(), view->serverRoot) << "the client hashes what it holds itself";

  const auto second = link(server);
  const auto same = inStep(*second, 1);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->meshes, view->meshes) << "who connects anew gets no copy";
}

TEST_F(EmbeddedServerTest, FreesAMeshOnceNeitherSideUsesIt) {
  EmbeddedServer server(optionsWith(kScene), [] {});
  const auto viewer = link(server);
  auto view = inStep(*viewer, 1);
  ASSERT_TRUE(view) << viewer->latest()->linkText;
  const ContentHash ball = view->scene->find("ball")->mesh;
  const std::weak_ptr<const TriMesh> replaced = view->meshes.at(ball);

  v1::Transaction transaction;
  v1::RemeshObject& remesh = *transaction.add_operations()->mutable_remesh();
  remesh.mutable_object()->set_name("ball");
  remesh.mutable_mesh()->mutable_sphere()->set_radius_m(0.04);
  ASSERT_EQ(apply(*viewer, transaction), "accepted");
  const auto after = inStep(*viewer, 2);
  ASSERT_TRUE(after);
  EXPECT_TRUE(eventually([&] { return !server.sharedAssets()({AssetKind::kMesh, ball}); })) << "the server is done";
  EXPECT_EQ(replaced.lock(), view->meshes.at(ball)) << "and what is drawn stays";
  view = nullptr;
  EXPECT_TRUE(eventually([&] { return replaced.expired(); }));

  const std::weak_ptr<const TriMesh> removed = after->meshes.at(after->scene->find("ball")->mesh);
  transaction.Clear();
  transaction.add_operations()->mutable_remove()->mutable_object()->set_name("ball");
  ASSERT_EQ(apply(*viewer, transaction), "accepted");
  ASSERT_TRUE(inStep(*viewer, 3));
  EXPECT_FALSE(removed.expired()) << "a view of it is held here";
}

TEST_F(EmbeddedServerTest, LetsTheViewerGoOnWhileItLoadsItsScene) {
  EmbeddedServer server(
      optionsWith(R"(operations { add { name: "fine" mesh { sphere { radius_m: 0.05 segments: 900 } } } })"), [] {});
  const auto viewer = link(server);
  const auto view =
      viewer->waitUntil([](const MirrorView& v) { return v.linkText.ends_with("loading its scene"); }, kPatience);
  ASSERT_TRUE(view) << viewer->latest()->linkText;
  EXPECT_EQ(view->connections, 0U);
  EXPECT_TRUE(server.stop()) << "a start that is given up is no failure";
  EXPECT_FALSE(server.isStillBuilding());
  EXPECT_EQ(viewer->latest()->connections, 0U) << "the scene was not loaded to its end";
}

TEST_F(EmbeddedServerTest, SaysWhyItCannotStart) {
  ServerOptions options = optionsWith(kScene);
  options.scene += "of another name";
  std::promise<void> failed;
  EmbeddedServer server(options, [&] { failed.set_value(); });
  ASSERT_EQ(failed.get_future().wait_for(kPatience), std::future_status::ready);
  const Result<void> stopped = server.stop();
  ASSERT_FALSE(stopped);
  EXPECT_THAT(stopped.error().text(), testing::HasSubstr("of another name"));
}

}  // namespace
}  // namespace haptics::embedded_server_test
