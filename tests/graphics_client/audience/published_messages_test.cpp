#include "graphics_client/audience/published_messages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/graphics_client/audience/published_session.h"

namespace haptics::published_messages_test {
namespace {

v1::AssetChunk chunkOf(const ContentHash& asset, std::uint64_t index, std::uint64_t total_bytes) {
  v1::AssetChunk chunk;
  chunk.set_hash(asset.asBytes());
  chunk.set_kind(v1::ASSET_KIND_MESH);
  chunk.set_total_size(total_bytes);
  chunk.set_offset(index * kPublishedChunk_bytes);
  chunk.set_data(std::string(std::min<std::uint64_t>(kPublishedChunk_bytes, total_bytes - chunk.offset()), 'x'));
  return chunk;
}

template <class Message>
std::string changed(Message message, const std::function<void(Message&)>& change) {
  change(message);
  return message.SerializeAsString();
}

TEST(PublishedMessages, OfAnotherVersionOrEpoch0AreRefusedByName) {
  PublishedSession published;
  v1::PublishedCommit commit = published.commit("c");
  ASSERT_TRUE(readPublishedCommit(commit.SerializeAsString()));
  commit.set_protocol_version(2);
  EXPECT_EQ(readPublishedCommit(commit.SerializeAsString()).error().field, "published_commit.protocol_version");
  commit.set_protocol_version(1);
  commit.set_epoch(0);
  EXPECT_EQ(readPublishedCommit(commit.SerializeAsString()).error().field, "published_commit.epoch");
}

TEST(PublishedMessages, LargerThanAFrameAreRefused) {
  v1::LiveMessage live;
  live.set_protocol_version(1);
  live.set_epoch(1);
  live.mutable_telemetry()
      ->GetReflection()
      ->MutableUnknownFields(live.mutable_telemetry())
      ->AddLengthDelimited(1000, std::string(kMaxFrameBytes, 'x'));
  EXPECT_FALSE(readLiveMessage(live.SerializeAsString()));
}

TEST(PublishedMessages, TheLatestSnapshotNeedsWhatAReaderComputesWith) {
  const v1::LatestSnapshot good = PublishedSession().latest();
  ASSERT_TRUE(readLatestSnapshot(good.SerializeAsString()));
  using Change = std::function<void(v1::LatestSnapshot&)>;
  for (const Change& change :
       {Change([](auto& m) { m.set_sequence(0); }), Change([](auto& m) { m.mutable_welcome()->set_epoch(0); }),
        Change([](auto& m) { m.mutable_welcome()->set_root("short"); }),
        Change([](auto& m) { m.mutable_welcome()->set_device(std::string(1001, 'x')); }),
        Change([](auto& m) { m.clear_welcome(); })}) {
    EXPECT_FALSE(readLatestSnapshot(changed(good, change)));
  }
}

TEST(PublishedMessages, AChunkIsWhereItsIndexSays) {
  const ContentHash asset{{1}};
  const std::uint64_t total_bytes = kPublishedChunk_bytes + 5;
  for (const std::uint64_t index : {0U, 1U}) {
    EXPECT_TRUE(readAssetChunk(chunkOf(asset, index, total_bytes).SerializeAsString(), asset, index)) << index;
    EXPECT_FALSE(readAssetChunk(chunkOf(asset, index, total_bytes).SerializeAsString(), asset, 1 - index)) << index;
  }
  const v1::AssetChunk good = chunkOf(asset, 1, total_bytes);
  EXPECT_FALSE(readAssetChunk(good.SerializeAsString(), ContentHash{{2}}, 1));
  using Change = std::function<void(v1::AssetChunk&)>;
  for (const Change& change :
       {Change([](auto& m) { m.set_total_size(m.offset()); }), Change([](auto& m) { m.set_total_size(~0ULL); }),
        Change([](auto& m) { m.clear_data(); }), Change([](auto& m) { m.mutable_data()->push_back('x'); })}) {
    EXPECT_FALSE(readAssetChunk(changed(good, change), asset, 1));
  }
}

/// Whatever bits are wrong, a message is refused or read; a scene is taken only with the root that it names.
TEST(PublishedMessages, AnyDamageIsRefusedOrHarmless) {
  PublishedSession published;
  published.storeSnapshot();
  const ContentHash before = published.server.scene.root();
  published.store(published.subjects.commit, published.commit("c").SerializeAsString());
  const ContentHash after = published.server.scene.root();
  std::mt19937 random(1);
  const auto draw = [&](std::size_t below) { return std::uniform_int_distribution<std::size_t>(0, below - 1)(random); };
  constexpr std::size_t kTries = 5000;
  std::size_t refusals = 0;
  for (std::size_t i = 0; i < kTries; ++i) {
    std::vector<StoredMessage> damaged = published.stored;
    std::string& bytes = damaged[draw(damaged.size())].bytes;
    for (std::size_t flips = 1 + draw(3); flips > 0; --flips)
      bytes[draw(bytes.size())] ^= static_cast<char>(1U << draw(8));
    if (draw(4) == 0) bytes.resize(draw(bytes.size()));
    (void)readLiveMessage(bytes);
    (void)readLatestSnapshot(bytes);
    (void)readAssetChunk(bytes, ContentHash{{1}}, draw(4));
    const auto session = published.read(damaged);
    EXPECT_TRUE(!session || session->scene.root() == before || session->scene.root() == after);
    refusals += !session;
  }
  EXPECT_GT(refusals, kTries / 2);
}

}  // namespace
}  // namespace haptics::published_messages_test
