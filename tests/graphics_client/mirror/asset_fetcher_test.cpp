#include "graphics_client/mirror/asset_fetcher.h"

#include <gmock/gmock.h>

#include <functional>

namespace haptics::asset_fetcher_test {
namespace {

ContentHash name(std::uint64_t number) { return Hasher().add(number).finish(); }

AssetName mesh(std::uint64_t number) { return {AssetKind::kMesh, name(number)}; }

v1::AssetChunk chunk(const ContentHash& hash, std::uint64_t offset, const std::string& data, std::uint64_t total = 10) {
  v1::AssetChunk c;
  c.set_hash(hash.asBytes());
  c.set_kind(v1::ASSET_KIND_MESH);
  c.set_total_size(total);
  c.set_offset(offset);
  c.set_data(data);
  return c;
}

std::vector<v1::AssetRequest> requests(AssetFetcher& fetcher) {
  std::vector<v1::AssetRequest> all;
  while (auto request = fetcher.next()) all.push_back(*request);
  return all;
}

TEST(AssetFetcher, AsksOnceForEachAssetThatIsLacking) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1), mesh(2)});
  EXPECT_EQ(requests(fetcher).size(), 2U);
  fetcher.want({mesh(1), mesh(2)});
  EXPECT_TRUE(requests(fetcher).empty());
}

TEST(AssetFetcher, KeepsFewInFlight) {
  AssetFetcher fetcher;
  std::vector<AssetName> many;
  for (std::uint64_t i = 0; i < 20; ++i) many.push_back(mesh(i));
  fetcher.want(many);
  const auto first = requests(fetcher);
  ASSERT_EQ(first.size(), AssetFetcher::kMaxInFlight);
  const auto done = fetcher.take(chunk(*ContentHash::fromBytes(first[0].hash()), 0, "0123456789"));
  ASSERT_TRUE(done && *done);
  EXPECT_EQ(requests(fetcher).size(), 1U);
}

TEST(AssetFetcher, PutsChunksTogether) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1)});
  (void)requests(fetcher);
  EXPECT_FALSE(*fetcher.take(chunk(name(1), 0, "0123")));
  EXPECT_FALSE(*fetcher.take(chunk(name(1), 4, "456")));
  const auto done = fetcher.take(chunk(name(1), 7, "789"));
  ASSERT_TRUE(done && *done);
  EXPECT_EQ((*done)->name, mesh(1));
  EXPECT_EQ((*done)->bytes, "0123456789");
}

TEST(AssetFetcher, GoesOnWhereItWasAfterAReconnect) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1)});
  EXPECT_EQ(requests(fetcher)[0].offset(), 0U);
  (void)fetcher.take(chunk(name(1), 0, "0123"));
  fetcher.connectionLost();
  const auto again = requests(fetcher);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].offset(), 4U);
  const auto done = fetcher.take(chunk(name(1), 4, "456789"));
  ASSERT_TRUE(done && *done);
  EXPECT_EQ((*done)->bytes, "0123456789");
}

TEST(AssetFetcher, GivesUpWhatIsNoLongerWanted) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1)});
  (void)requests(fetcher);
  fetcher.want({});
  EXPECT_FALSE(*fetcher.take(chunk(name(1), 0, "0123456789")));
}

TEST(AssetFetcher, IgnoresChunksOfARequestThatWasMadeAgain) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1)});
  (void)requests(fetcher);
  (void)fetcher.take(chunk(name(1), 0, "0123"));
  fetcher.want({});
  fetcher.want({mesh(1)});
  EXPECT_EQ(requests(fetcher)[0].offset(), 0U);
  EXPECT_FALSE(*fetcher.take(chunk(name(1), 4, "456789")));  // of the first request
  const auto done = fetcher.take(chunk(name(1), 0, "0123456789"));
  ASSERT_TRUE(done && *done);
}

TEST(AssetFetcher, AsksLaterForWhatTheServerDoesNotHold) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1)});
  (void)requests(fetcher);
  fetcher.unavailable(name(1).asBytes());
  EXPECT_TRUE(requests(fetcher).empty());
  fetcher.retry();
  EXPECT_EQ(requests(fetcher).size(), 1U);
}

TEST(AssetFetcher, RefusesChunksThatDoNotFit) {
  const std::vector<std::pair<std::string, std::function<void(v1::AssetChunk&)>>> cases = {
      {"asset_chunk.hash", [](auto& c) { c.set_hash("short"); }},
      {"asset_chunk.kind", [](auto& c) { c.set_kind(v1::ASSET_KIND_IMAGE); }},
      {"asset_chunk.kind", [](auto& c) { c.set_kind(v1::ASSET_KIND_SCALAR_FIELD); }},
      {"asset_chunk.total_size", [](auto& c) { c.set_total_size(0); }},
      {"asset_chunk.total_size", [](auto& c) { c.set_total_size(11); }},
      {"asset_chunk.total_size", [](auto& c) { c.set_total_size(1ULL << 62); }},
      {"asset_chunk.data", [](auto& c) { c.set_data(""); }},
      {"asset_chunk.data", [](auto& c) { c.set_data("4567890"); }},
  };
  for (const auto& [field, spoil] : cases) {
    AssetFetcher fetcher;
    fetcher.want({mesh(1)});
    (void)requests(fetcher);
    ASSERT_TRUE(fetcher.take(chunk(name(1), 0, "0123")));
    v1::AssetChunk bad = chunk(name(1), 4, "456");
    spoil(bad);
    const auto taken = fetcher.take(bad);
    ASSERT_FALSE(taken) << field;
    EXPECT_EQ(taken.error().field, field);
  }
}

TEST(AssetFetcher, RefusesAnAbsurdSizeInTheFirstChunk) {
  AssetFetcher fetcher;
  fetcher.want({mesh(1)});
  (void)requests(fetcher);
  EXPECT_FALSE(fetcher.take(chunk(name(1), 0, "0123", 1ULL << 62)));
}

}  // namespace
}  // namespace haptics::asset_fetcher_test
