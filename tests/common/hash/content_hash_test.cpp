#include "common/hash/content_hash.h"

#include <gtest/gtest.h>

#include <limits>
#include <unordered_set>

namespace haptics::content_hash_test {
namespace {

std::span<const std::byte> bytesOf(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST(Hasher, GivesTheDigestOfThePublishedTestVector) {  // FIPS 180-2, appendix B.1
  EXPECT_EQ(Hasher().add(bytesOf("abc")).finish().hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Hasher, GivesTheDigestOfNothing) {
  EXPECT_EQ(Hasher().finish().hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Hasher, TakesIntegersAsEightLittleEndianBytes) {
  const char raw[] = {0x08, 0x07, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01};
  EXPECT_EQ(Hasher().add(std::uint64_t{0x0102030405060708}).finish(),
            Hasher().add(bytesOf({raw, sizeof raw})).finish());
}

TEST(Hasher, TakesFloatsAtTheirOwnWidth) { EXPECT_NE(Hasher().add(1.5).finish(), Hasher().add(1.5F).finish()); }

TEST(Hasher, HashesMinusZeroAsZero) {
  EXPECT_EQ(Hasher().add(-0.0).finish(), Hasher().add(0.0).finish());
  EXPECT_EQ(Hasher().add(-0.0F).finish(), Hasher().add(0.0F).finish());
}

TEST(Hasher, TellsTheSmallestNumbersFromZero) {
  EXPECT_NE(Hasher().add(std::numeric_limits<double>::denorm_min()).finish(), Hasher().add(0.0).finish());
}

TEST(Hasher, TellsWhereOneTextEndsAndTheNextBegins) {
  const auto hash = [](std::string_view a, std::string_view b) { return Hasher().add(a).add(b).finish(); };
  EXPECT_NE(hash("ab", "c"), hash("a", "bc"));
  EXPECT_NE(hash("", "abc"), hash("abc", ""));
}

TEST(Hasher, DependsOnTheOrder) { EXPECT_NE(Hasher().add(1.0).add(2.0).finish(), Hasher().add(2.0).add(1.0).finish()); }

TEST(ContentHash, SurvivesTheWayOverTheWire) {
  const ContentHash hash = Hasher().add(std::uint64_t{7}).finish();
  EXPECT_EQ(ContentHash::fromBytes(hash.asBytes()), hash);
}

TEST(ContentHash, IsNotMadeOfTooFewOrTooManyBytes) {
  for (const std::size_t size : {0, 1, 31, 33, 64}) {
    EXPECT_FALSE(ContentHash::fromBytes(std::string(size, 'x'))) << size;
  }
}

TEST(ContentHash, IsZeroOnlyWhenEveryByteIs) {
  EXPECT_TRUE(ContentHash{}.isZero());
  for (std::size_t i = 0; i < 32; ++i) {
    ContentHash hash;
    hash.bytes[i] = 1;
    EXPECT_FALSE(hash.isZero()) << i;
  }
}

TEST(ContentHash, WritesTwoLowerCaseDigitsForEachByte) {
  ContentHash hash;
  hash.bytes[0] = 0x0A;
  hash.bytes[31] = 0xF1;
  EXPECT_EQ(hash.hex(), "0a" + std::string(60, '0') + "f1");
}

TEST(ContentHash, CanBeKeptInHashTables) {
  std::unordered_set<ContentHash> table;
  for (std::uint64_t i = 0; i < 100; ++i) table.insert(Hasher().add(i).finish());
  EXPECT_EQ(table.size(), 100U);
  EXPECT_TRUE(table.contains(Hasher().add(std::uint64_t{42}).finish()));
}

}  // namespace
}  // namespace haptics::content_hash_test
