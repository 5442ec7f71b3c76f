#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "common/surface/field_asset.h"
#include "tests/haptic_server/net/session_world.h"

namespace haptics::session_assets_test {
namespace {

using namespace test;
using ::testing::StartsWith;
using Kind = v1::Envelope;

class SessionAssets : public ::testing::Test, public SessionWorld {
 protected:
  SessionAssets() { join(); }

  ContentHash addLarge() { return edit(test::edit(add("large", {BoxSource{Vec3(1), 60}})))->commit.put[0].mesh; }
  std::string fetched(const ContentHash& hash) const {
    std::string bytes;
    for (const auto& envelope : client.all(Kind::kAssetChunk)) {
      const v1::AssetChunk& chunk = envelope.asset_chunk();
      if (chunk.hash() != hash.asBytes()) continue;
      EXPECT_EQ(chunk.offset(), bytes.size());
      EXPECT_LE(chunk.data().size(), kMaxChunkBytes);
      bytes += chunk.data();
    }
    return bytes;
  }
  /// Sends bytes as an upload, in chunks.
  void uploadAll(const ContentHash& hash, const std::string& bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += 30'000) {
      client.upload(hash, bytes.size(), at, bytes.substr(at, 30'000));
    }
    link.settle();
  }
  v1::AssetUploadReply lastReply() const {
    const auto replies = client.all(Kind::kAssetUploadReply);
    return replies.empty() ? v1::AssetUploadReply{} : replies.back().asset_upload_reply();
  }
  std::string refusedField(const ContentHash& hash, std::uint64_t total, std::uint64_t offset, std::string data) {
    client.got.clear();
    client.upload(hash, total, offset, std::move(data));
    link.settle();
    EXPECT_EQ(client.count(Kind::kAssetUploadReply), 1U);
    EXPECT_FALSE(lastReply().accepted());
    EXPECT_FALSE(lastReply().reason().empty());
    return lastReply().field();
  }

  const TriMesh mesh_ = makeBox(Vec3(0.5), 40).value();
  const std::string bytes_ = encodeMesh(mesh_);
  const ContentHash hash_ = hashOf(mesh_);
};

TEST_F(SessionAssets, SendsAnAssetInChunksFromTheOffsetAskedFor) {
  const ContentHash large = addLarge();
  const std::string whole = findAsset(large)->bytes().copy();
  ASSERT_GT(whole.size(), 4 * kMaxChunkBytes);
  client.requestAsset(large);
  link.settle();
  EXPECT_EQ(fetched(large), whole);

  client.got.clear();
  client.requestAsset(large, whole.size() - 5);
  link.settle();
  ASSERT_EQ(client.count(Kind::kAssetChunk), 1U);
  EXPECT_EQ(client.got.back().asset_chunk().data(), whole.substr(whole.size() - 5));
}

TEST_F(SessionAssets, HeartbeatsEditsAndTelemetryGoBetweenTheChunks) {
  const ContentHash large = addLarge();
  client.subscribe(1000);
  client.requestAsset(large);
  link.pump();
  std::map<int, std::vector<std::size_t>> places;
  for (std::uint64_t tick = 1; !refusals.empty() || client.count(Kind::kTelemetry) < 3; ++tick) {
    time_ns += 500 * kMillisecond_ns;
    TelemetrySample sample;
    sample.tick = tick;
    session.offerTelemetry(sample);
    session.poll();
    if (tick < 4) client.moveObject(tick, "large", 1);
    EXPECT_LT(serverEnd->backlog(), 2 * kMaxChunkBytes);
    link.pump();
    ASSERT_LT(tick, 50U);
  }
  EXPECT_LT(fetched(large).size(), findAsset(large)->bytes().size()) << "still under way";
  EXPECT_GE(client.count(Kind::kHeartbeat), 1U);
  EXPECT_GE(client.count(Kind::kEditReply), 1U);
}

TEST_F(SessionAssets, AnAssetUnderWayOutlivesItsObject) {
  const ContentHash large = addLarge();
  const std::string whole = findAsset(large)->bytes().copy();
  client.requestAsset(large);
  link.pump();
  edit(test::edit(remove("large")));
  link.settle();
  EXPECT_EQ(fetched(large), whole);
  client.requestAsset(large);
  link.settle();
  EXPECT_EQ(client.count(Kind::kAssetUnavailable), 1U);
  EXPECT_EQ(findAsset(large), nullptr);
}

TEST_F(SessionAssets, AnAssetThatOnlyWaitsToBeSentIsHeldByNobody) {
  const ContentHash large = addLarge();
  const ContentHash other = edit(test::edit(add("other", {BoxSource{Vec3(2), 60}})))->commit.put[0].mesh;
  client.requestAsset(large);
  client.requestAsset(other);
  link.pump();
  edit(test::edit(remove("other")));
  EXPECT_EQ(findAsset(other), nullptr);
  link.settle();
  EXPECT_EQ(fetched(large), findAsset(large)->bytes().copy());
  EXPECT_EQ(client.count(Kind::kAssetUnavailable), 1U);
}

TEST_F(SessionAssets, RefusesARequestThatMakesNoSense) {
  for (const bool beyond : {true, false}) {
    SessionWorld world;
    world.join();
    const auto asset = world.edit(test::edit(add("a")))->commit.put[0].mesh;
    v1::Envelope envelope;
    envelope.mutable_asset_request()->set_hash(beyond ? asset.asBytes() : "short");
    envelope.mutable_asset_request()->set_offset(1U << 30);
    world.client.send(envelope);
    world.link.settle();
    EXPECT_EQ(world.client.refusal().field(), beyond ? "asset_request.offset" : "asset_request.hash");
  }
}

TEST_F(SessionAssets, AnUploadMayBeNamedByAnEdit) {
  uploadAll(hash_, bytes_);
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 0U);
  decideAssets();
  EXPECT_TRUE(lastReply().accepted());
  EXPECT_EQ(lastReply().hash(), hash_.asBytes());
  EXPECT_NE(findAsset(hash_), nullptr) << "held until an edit names it";
  EXPECT_EQ(reserved, bytes_.size());

  auto accepted = std::make_shared<AcceptedEdit>();
  accepted->commit.put.push_back({});
  accepted->commit.put[0].mesh = hash_;
  session.editDecided(1, EditOutcome(accepted));
  EXPECT_EQ(findAsset(hash_), nullptr) << "the scene would hold it now";
  EXPECT_EQ(reserved, 0U);
}

TEST_F(SessionAssets, UploadsOfAWholeSceneAreHeldUntilOneEditNamesThem) {
  constexpr int kUploads = 256;
  std::vector<ContentHash> hashes;
  for (int i = 0; i < kUploads; ++i) {
    const SampledField field = BoxResolver::smallField(static_cast<float>(i + 1));
    const std::string bytes = encodeField(field);
    hashes.push_back(hashOf(field));
    client.upload(hashes.back(), bytes.size(), 0, bytes, v1::ASSET_KIND_SCALAR_FIELD);
    link.settle();
    decideAssets();
  }
  for (const ContentHash& hash : hashes) EXPECT_NE(findAsset(hash), nullptr);
}

TEST_F(SessionAssets, AFieldIsUploadedAndSentLikeAMesh) {
  const SampledField field = BoxResolver::smallField(3);
  const std::string bytes = encodeField(field);
  client.upload(hashOf(field), bytes.size(), 0, bytes, v1::ASSET_KIND_SCALAR_FIELD);
  link.settle();
  decideAssets();
  EXPECT_TRUE(lastReply().accepted());
  client.requestAsset(hashOf(field));
  link.settle();
  EXPECT_EQ(fetched(hashOf(field)), bytes);
  EXPECT_EQ(client.got.back().asset_chunk().kind(), v1::ASSET_KIND_SCALAR_FIELD);
}

TEST_F(SessionAssets, AnUploadThatTheServerHoldsIsAcceptedAtOnce) {
  const ContentHash large = addLarge();
  const std::string whole = findAsset(large)->bytes().copy();
  uploadAll(large, whole);
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 1U);
  EXPECT_TRUE(lastReply().accepted());
  EXPECT_TRUE(building.empty());
}

TEST_F(SessionAssets, WhatIsHeldCountsThoughTheServerHadIt) {
  const ContentHash large = addLarge();
  const std::string bytes = findAsset(large)->bytes().copy();
  for (int time = 0; time < 2; ++time) {
    client.upload(large, bytes.size(), 0, bytes.substr(0, 1000));
    link.settle();
    EXPECT_TRUE(lastReply().accepted());
    EXPECT_EQ(reserved, bytes.size());
  }
  client.cancelUpload(large);
  link.settle();
  EXPECT_EQ(reserved, 0U);
  uploadBudget = 1000;
  client.upload(large, bytes.size(), 0, bytes.substr(0, 1000));
  link.settle();
  EXPECT_GT(lastReply().retry_after_ms(), 0U);
}

TEST_F(SessionAssets, BytesThatDoNotHashToWhatWasDeclaredAreRefused) {
  std::string wrong = bytes_;
  wrong.back() ^= 1;
  uploadAll(hash_, wrong);
  decideAssets();
  EXPECT_FALSE(lastReply().accepted());
  EXPECT_EQ(lastReply().field(), "chunk.hash");
  EXPECT_EQ(findAsset(hash_), nullptr);
  EXPECT_EQ(reserved, 0U);
  EXPECT_FALSE(client.closed);
}

TEST_F(SessionAssets, RefusesBadChunksByField) {
  EXPECT_EQ(refusedField(hash_, 0, 0, "x"), "chunk.total_size");
  EXPECT_EQ(refusedField(hash_, kMaxUploadBytes + 1, 0, "x"), "chunk.total_size");
  EXPECT_EQ(refusedField(hash_, 100, 0, ""), "chunk.data");
  EXPECT_EQ(refusedField(hash_, 1 << 20, 0, std::string(kMaxChunkBytes + 1, 'x')), "chunk.data");
  EXPECT_EQ(refusedField(hash_, 3, 0, "four"), "chunk.data");
  EXPECT_EQ(refusedField(hashOf(makeBox(Vec3(1), 1).value()), 100, 50, "x"), "chunk.offset");

  v1::Envelope envelope;
  envelope.mutable_asset_upload()->mutable_chunk()->set_hash("short");
  client.send(envelope);
  envelope.mutable_asset_upload()->mutable_chunk()->set_hash(hash_.asBytes());
  envelope.mutable_asset_upload()->mutable_chunk()->set_kind(v1::ASSET_KIND_IMAGE);
  client.send(envelope);
  link.settle();
  const auto replies = client.all(Kind::kAssetUploadReply);
  EXPECT_EQ(replies.at(replies.size() - 2).asset_upload_reply().field(), "chunk.hash");
  EXPECT_EQ(lastReply().field(), "chunk.kind");
  EXPECT_EQ(reserved, 0U);
}

TEST_F(SessionAssets, ARefusedUploadIsAnsweredOnceThoughItsChunksAreUnderWay) {
  uploadBudget = bytes_.size() - 1;
  uploadAll(hash_, bytes_);
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 1U);
  EXPECT_EQ(lastReply().field(), "chunk.total_size");
  uploadBudget = bytes_.size();
  uploadAll(hash_, bytes_);
  decideAssets();
  EXPECT_TRUE(lastReply().accepted());
}

TEST_F(SessionAssets, AnUploadThatIsOnlyAnnouncedHoldsLittleOfTheBudget) {
  client.upload(hash_, kMaxUploadBytes, 0, "x");
  link.settle();
  EXPECT_LE(reserved, 1U << 20);
}

TEST_F(SessionAssets, AnUploadThatStallsIsGivenUp) {
  client.upload(hash_, bytes_.size(), 0, bytes_.substr(0, 1000));
  link.settle();
  for (int i = 0; i < 9; ++i) {
    client.heartbeat();
    pass(kSecond_ns);
  }
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 0U);
  client.heartbeat();
  pass(2 * kSecond_ns);
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 1U);
  EXPECT_EQ(lastReply().field(), "chunk");
  EXPECT_EQ(reserved, 0U);
  EXPECT_FALSE(client.closed);
  client.got.clear();
  uploadAll(hash_, bytes_);
  decideAssets();
  EXPECT_TRUE(lastReply().accepted());
}

TEST_F(SessionAssets, ANewUploadReplacesAnUnfinishedOne) {
  client.upload(hash_, bytes_.size(), 0, bytes_.substr(0, 1000));
  link.settle();
  EXPECT_EQ(reserved, bytes_.size());
  const std::string small = encodeMesh(makeBox(Vec3(1), 1).value());
  uploadAll(hashOf(makeBox(Vec3(1), 1).value()), small);
  EXPECT_EQ(reserved, small.size());
  EXPECT_EQ(building.size(), 1U);
}

TEST_F(SessionAssets, GivesTheUploadBudgetBackWhenTheClientLeaves) {
  uploadAll(hash_, bytes_);
  client.upload(hashOf(makeBox(Vec3(2), 3).value()), 5000, 0, "x");
  link.settle();
  EXPECT_EQ(reserved, bytes_.size() + 5000);
  link.cut("gone");
  EXPECT_TRUE(over);
  EXPECT_EQ(reserved, bytes_.size()) << "the builder still has the bytes of one";
  decideAssets();
  EXPECT_EQ(reserved, 0U);
  EXPECT_EQ(findAsset(hash_), nullptr);
}

TEST_F(SessionAssets, AnUploadThatIsCancelledUnderWayGivesItsMemoryBack) {
  client.upload(hash_, bytes_.size(), 0, bytes_.substr(0, 30'000));
  link.settle();
  EXPECT_EQ(reserved, bytes_.size());
  client.cancelUpload(hash_);
  client.upload(hash_, bytes_.size(), 30'000, bytes_.substr(30'000, 30'000));  // was on its way
  link.settle();
  EXPECT_EQ(reserved, 0U);
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 0U);
  uploadAll(hash_, bytes_);
  decideAssets();
  EXPECT_TRUE(lastReply().accepted()) << "may be begun again";
}

TEST_F(SessionAssets, AnUploadThatIsCancelledWhileItIsBuiltKeepsItsMemoryUntilThen) {
  uploadAll(hash_, bytes_);
  client.cancelUpload(hash_);
  link.settle();
  EXPECT_EQ(reserved, bytes_.size()) << "the builder has the bytes";
  decideAssets();
  EXPECT_EQ(reserved, 0U);
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 0U);
  EXPECT_EQ(findAsset(hash_), nullptr);
}

TEST_F(SessionAssets, AnUploadThatIsCancelledAndBegunAgainWhileItIsBuiltIsAnswered) {
  uploadAll(hash_, bytes_);
  client.cancelUpload(hash_);
  uploadAll(hash_, bytes_);
  decideAssets();
  EXPECT_TRUE(lastReply().accepted());
  EXPECT_EQ(client.count(Kind::kAssetUploadReply), 1U);
}

TEST_F(SessionAssets, AnUploadThatIsHeldCanBeCancelled) {
  uploadAll(hash_, bytes_);
  decideAssets();
  client.cancelUpload(hash_);
  link.settle();
  EXPECT_EQ(reserved, 0U);
  EXPECT_EQ(findAsset(hash_), nullptr);
}

}  // namespace
}  // namespace haptics::session_assets_test
