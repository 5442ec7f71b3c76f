#include "graphics_client/mirror/asset_uploader.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/mesh/mesh_asset.h"
#include "common/wire/framing.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics::asset_uploader_test {
namespace {

constexpr std::uint64_t kNow_ns = 1'000'000'000'000;
constexpr std::uint64_t kSecond_ns = 1'000'000'000;

v1::AssetUploadReply reply(const TriMesh& mesh, bool accepted) {
  v1::AssetUploadReply message;
  message.set_hash(hashOf(mesh).asBytes());
  message.set_accepted(accepted);
  return message;
}

/// Puts together what is sent until nothing more comes; each chunk must be the next.
std::string sendAll(AssetUploader& uploader) {
  std::string bytes;
  while (const auto upload = uploader.next()) {
    EXPECT_EQ(upload->chunk().offset(), bytes.size());
    EXPECT_LE(upload->ByteSizeLong(), kMaxChunkBytes);
    bytes += upload->chunk().data();
  }
  return bytes;
}

TEST(AssetUploader, SendsAMeshUnderTheHashOfItsContent) {
  AssetUploader uploader;
  const TriMesh mesh = grid(60);
  uploader.add(AssetKind::kMesh, encodeMesh(mesh), {});
  const auto first = uploader.next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->chunk().hash(), hashOf(mesh).asBytes());
  EXPECT_EQ(first->chunk().kind(), v1::ASSET_KIND_MESH);
  EXPECT_EQ(first->chunk().total_size(), encodeMesh(mesh).size());
}

TEST(AssetUploader, SendsEveryByteOnceAndReportsProgress) {
  AssetUploader uploader;
  const std::string bytes = encodeMesh(grid(100));
  std::uint64_t last = 0;
  uploader.add(AssetKind::kMesh, bytes,
               {.progress =
                    [&](std::uint64_t sent, std::uint64_t total) {
                      EXPECT_GT(sent, last);
                      EXPECT_EQ(total, bytes.size());
                      last = sent;
                    },
                .finished = {}});
  EXPECT_EQ(sendAll(uploader), bytes);
  EXPECT_EQ(last, bytes.size());
}

TEST(AssetUploader, SendsTheNextMeshOnlyAfterTheReply) {
  AssetUploader uploader;
  int finished = 0;
  uploader.add(AssetKind::kMesh, encodeMesh(tetrahedron(1)), {.progress = {}, .finished = [&](const auto& r) {
                                                                EXPECT_TRUE(r.accepted());
                                                                ++finished;
                                                              }});
  uploader.add(AssetKind::kMesh, encodeMesh(tetrahedron(2)), {});
  EXPECT_EQ(sendAll(uploader), encodeMesh(tetrahedron(1)));
  uploader.replied(reply(tetrahedron(2), true), kNow_ns);  // not asked yet
  EXPECT_EQ(finished, 0);
  uploader.replied(reply(tetrahedron(1), true), kNow_ns);
  EXPECT_EQ(finished, 1);
  EXPECT_EQ(sendAll(uploader), encodeMesh(tetrahedron(2)));
}

TEST(AssetUploader, StopsAnUploadThatIsRefusedUnderWay) {
  AssetUploader uploader;
  bool refused = false;
  uploader.add(AssetKind::kMesh, encodeMesh(grid(100)),
               {.progress = {}, .finished = [&](const auto& r) { refused = !r.accepted(); }});
  (void)uploader.next();
  uploader.replied(reply(grid(100), false), kNow_ns);
  EXPECT_TRUE(refused);
  EXPECT_FALSE(uploader.next());
}

TEST(AssetUploader, TellsTheServerOnlyOfACancelledUploadThatWasBegun) {
  AssetUploader uploader;
  std::vector<std::string> ended;
  const auto finished = [&](const auto& r) { ended.push_back(r.accepted() ? "accepted" : r.reason()); };
  uploader.add(AssetKind::kMesh, encodeMesh(grid(100)), {.progress = {}, .finished = finished});
  uploader.add(AssetKind::kMesh, encodeMesh(grid(101)), {.progress = {}, .finished = finished});
  (void)uploader.next();
  EXPECT_FALSE(uploader.cancel(hashOf(grid(101))));
  EXPECT_TRUE(uploader.cancel(hashOf(grid(100))));
  EXPECT_FALSE(uploader.cancel(hashOf(grid(100))));
  EXPECT_EQ(ended, (std::vector<std::string>{"was cancelled", "was cancelled"}));
  EXPECT_FALSE(uploader.next());
  uploader.replied(reply(grid(100), true), kNow_ns);  // was on its way
  EXPECT_EQ(ended.size(), 2U);
}

TEST(AssetUploader, SendsAMeshForWhichThereWasNoRoomAgainAfterAWhileAndNotForEver) {
  AssetUploader uploader;
  bool refused = false;
  const std::string bytes = encodeMesh(grid(100));
  uploader.add(AssetKind::kMesh, bytes, {.progress = {}, .finished = [&](const auto& r) { refused = !r.accepted(); }});
  (void)uploader.next();
  v1::AssetUploadReply later = reply(grid(100), false);
  later.set_retry_after_ms(1000);
  uploader.replied(later, kNow_ns);
  uploader.poll(kNow_ns + kSecond_ns - 1);
  EXPECT_FALSE(uploader.next());
  uploader.poll(kNow_ns + kSecond_ns);
  EXPECT_EQ(sendAll(uploader), bytes);
  EXPECT_FALSE(refused);
  uploader.replied(later, kNow_ns + AssetUploader::kPatience_ns);
  EXPECT_TRUE(refused);
}

TEST(AssetUploader, IsPutOffForNoLongerThanItsPatience) {
  AssetUploader uploader;
  const std::string bytes = encodeMesh(grid(100));
  uploader.add(AssetKind::kMesh, bytes, {});
  (void)sendAll(uploader);
  v1::AssetUploadReply inWeeks = reply(grid(100), false);
  inWeeks.set_retry_after_ms(UINT32_MAX);
  uploader.replied(inWeeks, kNow_ns);
  uploader.poll(kNow_ns + AssetUploader::kPatience_ns);
  EXPECT_EQ(sendAll(uploader), bytes);
}

TEST(AssetUploader, StartsAnewAfterAReconnect) {
  AssetUploader uploader;
  const std::string bytes = encodeMesh(grid(100));
  uploader.add(AssetKind::kMesh, bytes, {});
  (void)uploader.next();
  uploader.connectionLost();
  EXPECT_EQ(sendAll(uploader), bytes);
  uploader.connectionLost();  // sent, but not answered
  EXPECT_EQ(sendAll(uploader), bytes);
}

TEST(AssetUploader, SendsAgainWhatNoEditHasNamedBeforeTheConnectionWasLost) {
  AssetUploader uploader;
  int finished = 0;
  for (const float size : {1.F, 2.F, 3.F}) {
    uploader.add(AssetKind::kMesh, encodeMesh(tetrahedron(size)),
                 {.progress = {}, .finished = [&](const auto&) { ++finished; }});
  }
  for (const float size : {1.F, 2.F}) {
    (void)sendAll(uploader);
    uploader.replied(reply(tetrahedron(size), true), kNow_ns);
  }
  uploader.named(hashOf(tetrahedron(1)));
  EXPECT_FALSE(uploader.sendsAgain());
  uploader.connectionLost();
  EXPECT_TRUE(uploader.sendsAgain());
  EXPECT_EQ(sendAll(uploader), encodeMesh(tetrahedron(2)));
  uploader.replied(reply(tetrahedron(2), true), kNow_ns);
  EXPECT_FALSE(uploader.sendsAgain());
  EXPECT_EQ(sendAll(uploader), encodeMesh(tetrahedron(3)));
  EXPECT_EQ(finished, 2);
}

TEST(AssetUploader, RefusesNoBytesAtOnce) {
  AssetUploader uploader;
  bool refused = false;
  uploader.add(AssetKind::kMesh, "", {.progress = {}, .finished = [&](const auto& r) { refused = !r.accepted(); }});
  EXPECT_TRUE(refused);
}

}  // namespace
}  // namespace haptics::asset_uploader_test
