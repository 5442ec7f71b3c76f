#include "common/wire/framing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace haptics::framing_test {
namespace {

v1::Envelope heartbeat(std::uint64_t id) {
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(id);
  envelope.mutable_heartbeat()->set_revision(id);
  return envelope;
}

std::string frame(const v1::Envelope& envelope) {
  std::string bytes;
  EXPECT_TRUE(appendFrame(bytes, envelope));
  return bytes;
}

/// A frame that claims this length, with the bytes that follow it.
std::string claim(std::uint32_t length, const std::string& body = {}) {
  std::string bytes;
  for (int shift : {0, 8, 16, 24}) bytes += static_cast<char>(length >> shift);
  return bytes + body;
}

/// Ids of the envelopes that are whole now.
std::vector<std::uint64_t> take(FrameDecoder& decoder) {
  std::vector<std::uint64_t> ids;
  for (;;) {
    const auto envelope = decoder.next();
    EXPECT_TRUE(envelope) << envelope.error().text();
    if (!envelope || !*envelope) return ids;
    ids.push_back((*envelope)->message_id());
  }
}

std::string errorField(FrameDecoder& decoder) {
  const auto envelope = decoder.next();
  return envelope ? "no error" : envelope.error().field;
}

TEST(Framing, GivesBackWhatWasSent) {
  FrameDecoder decoder;
  decoder.feed(frame(heartbeat(7)));
  const auto envelope = decoder.next();
  ASSERT_TRUE(envelope && *envelope);
  EXPECT_EQ((*envelope)->protocol_version(), kProtocolVersion);
  EXPECT_EQ((*envelope)->heartbeat().revision(), 7U);
  EXPECT_FALSE(*decoder.next());
}

TEST(Framing, StartsWithALittleEndianLength) {
  const std::string bytes = frame(heartbeat(1));
  EXPECT_EQ(static_cast<unsigned char>(bytes[0]), bytes.size() - 4);
  EXPECT_EQ(bytes.substr(1, 3), std::string(3, '\0'));
}

TEST(Framing, AppendsBehindWhatIsThere) {
  std::string bytes;
  for (const std::uint64_t id : {1, 2, 3}) EXPECT_TRUE(appendFrame(bytes, heartbeat(id)));
  FrameDecoder decoder;
  decoder.feed(bytes);
  EXPECT_EQ(take(decoder), (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST(Framing, WaitsForEveryByte) {
  const std::string bytes = frame(heartbeat(1)) + frame(heartbeat(2));
  const std::size_t first = frame(heartbeat(1)).size();
  FrameDecoder decoder;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    decoder.feed({&bytes[i], 1});
    const auto ids = take(decoder);
    const bool complete = i + 1 == first || i + 1 == bytes.size();
    EXPECT_EQ(ids.size(), complete ? 1U : 0U) << "after byte " << i;
  }
}

TEST(Framing, DoesNotCareWhereTheStreamIsCut) {
  std::mt19937_64 random(11);
  std::string bytes;
  std::vector<std::uint64_t> sent;
  for (std::uint64_t id = 1; id <= 200; ++id) {
    v1::Envelope envelope = heartbeat(id);
    envelope.mutable_asset_chunk()->set_data(std::string(random() % 3'000, 'd'));
    EXPECT_TRUE(appendFrame(bytes, envelope));
    sent.push_back(id);
  }
  for (int round = 0; round < 20; ++round) {
    FrameDecoder decoder;
    std::vector<std::uint64_t> got;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t size = std::min<std::size_t>(random() % 5'000, bytes.size() - at);
      decoder.feed({&bytes[at], size});
      at += size;
      std::ranges::copy(take(decoder), std::back_inserter(got));
    }
    EXPECT_EQ(got, sent);
  }
}

TEST(Framing, TakesTheLargestFrame) {
  v1::Envelope envelope = heartbeat(1);
  std::string& data = *envelope.mutable_asset_chunk()->mutable_data();
  data.resize(kMaxFrameBytes);
  data.resize(data.size() - (envelope.ByteSizeLong() - kMaxFrameBytes));
  ASSERT_EQ(envelope.ByteSizeLong(), kMaxFrameBytes);
  FrameDecoder decoder;
  decoder.feed(frame(envelope));
  EXPECT_EQ(take(decoder).size(), 1U);
}

TEST(Framing, RefusesToWriteALargerMessage) {
  v1::Envelope envelope = heartbeat(1);
  envelope.mutable_asset_chunk()->mutable_data()->resize(kMaxFrameBytes);
  std::string bytes = "before";
  const auto framed = appendFrame(bytes, envelope);
  ASSERT_FALSE(framed);
  EXPECT_EQ(framed.error().field, "frame.length");
  EXPECT_EQ(bytes, "before");
}

TEST(Framing, KeepsToTheLimitThatStandsAtEachFrame) {
  v1::Envelope envelope = heartbeat(1);
  envelope.mutable_asset_chunk()->mutable_data()->resize(2000);
  FrameDecoder decoder(1000);
  decoder.feed(frame(heartbeat(1)) + frame(envelope));
  ASSERT_TRUE(decoder.next()->has_value());
  decoder.setLimit(3000);
  EXPECT_EQ(take(decoder).size(), 1U);
  decoder.setLimit(1000);
  decoder.feed(frame(envelope));
  EXPECT_EQ(errorField(decoder), "frame.length");
}

TEST(Framing, RefusesAFrameThatClaimsMoreBeforeItsBytesCome) {
  for (const std::uint32_t length : {std::uint32_t{kMaxFrameBytes} + 1, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    FrameDecoder decoder;
    decoder.feed(claim(length));
    EXPECT_EQ(errorField(decoder), "frame.length") << length;
  }
}

TEST(Framing, RefusesAnEmptyFrame) {
  FrameDecoder decoder;
  decoder.feed(claim(0));
  EXPECT_EQ(errorField(decoder), "frame.length");
}

TEST(Framing, RefusesBytesThatAreNoEnvelope) {
  FrameDecoder decoder;
  decoder.feed(claim(4, "\xff\xff\xff\xff"));
  EXPECT_EQ(errorField(decoder), "frame");
}

TEST(Framing, RefusesAnEnvelopeWithoutBody) {
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  FrameDecoder decoder;
  decoder.feed(frame(envelope));
  EXPECT_EQ(errorField(decoder), "body");
}

TEST(Framing, LeavesAWrongVersionToTheSession) {
  v1::Envelope envelope = heartbeat(5);
  envelope.set_protocol_version(99);
  FrameDecoder decoder;
  decoder.feed(frame(envelope));
  EXPECT_EQ(take(decoder), std::vector<std::uint64_t>{5});
}

TEST(Framing, GivesWhatCameBeforeTheErrorAndStaysInError) {
  FrameDecoder decoder;
  decoder.feed(frame(heartbeat(1)) + claim(0));
  ASSERT_TRUE(decoder.next());
  EXPECT_EQ(errorField(decoder), "frame.length");
  decoder.feed(frame(heartbeat(2)));
  EXPECT_EQ(errorField(decoder), "frame.length");
}

TEST(Framing, SurvivesRandomBytes) {
  std::mt19937_64 random(12);
  int errors = 0;
  for (int round = 0; round < 2'000; ++round) {
    std::string bytes(random() % 64, '\0');
    for (char& b : bytes) b = static_cast<char>(random());
    if (round % 2 == 0) bytes = claim(static_cast<std::uint32_t>(bytes.size()), bytes);  // past the length check
    FrameDecoder decoder;
    decoder.feed(bytes);
    while (true) {
      const auto envelope = decoder.next();
      if (!envelope) ++errors;
      if (!envelope || !*envelope) break;
    }
  }
  EXPECT_GT(errors, 1'000);
}

TEST(Framing, SurvivesEveryBitFlippedInARealFrame) {
  const std::string good = frame(heartbeat(3)) + frame(heartbeat(4));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bytes = good;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ 1 << bit % 8);
    FrameDecoder decoder;
    decoder.feed(bytes);
    for (auto envelope = decoder.next(); envelope && *envelope; envelope = decoder.next()) {
      EXPECT_NE((*envelope)->body_case(), v1::Envelope::BODY_NOT_SET);
    }
  }
}

}  // namespace
}  // namespace haptics::framing_test
