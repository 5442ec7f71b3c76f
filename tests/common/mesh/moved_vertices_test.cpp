#include "common/mesh/moved_vertices.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace haptics::moved_vertices_test {
namespace {

const MovedVertices kMoved{{2, 5, 6}, {{0.1F, -0.2F, 0.3F}, {1, 2, 3}, {0, 0, -1}}};

std::string refusal(const std::string& bytes) {
  const auto moved = decodeMovedVertices(bytes);
  return moved ? "" : moved.error().field;
}

/// With a number of four bytes in place of what is there.
template <class T>
std::string with(T number, std::size_t at) {
  static_assert(sizeof number == 4);
  std::string bytes = encodeMovedVertices(kMoved);
  std::memcpy(bytes.data() + at, &number, sizeof number);
  return bytes;
}

constexpr std::size_t kVertices = 16, kPlaces = 28;  // where they begin

TEST(MovedVertices, ComeBackFromTheirBytesAndHashByThem) {
  const std::string bytes = encodeMovedVertices(kMoved);
  EXPECT_EQ(bytes.size(), 16U + 3 * 16);
  EXPECT_EQ(decodeMovedVertices(bytes).value(), kMoved);
  MovedVertices other = kMoved;
  EXPECT_EQ(hashOf(other), hashOf(kMoved));
  other.place[1].y += 1e-6F;
  EXPECT_NE(hashOf(other), hashOf(kMoved));
}

TEST(MovedVertices, AreRefusedWhereTheyAreWrongAndSayWhere) {
  const std::string bytes = encodeMovedVertices(kMoved);
  EXPECT_EQ(refusal(""), "magic");
  EXPECT_EQ(refusal("HVTX" + bytes.substr(4)), "magic");
  EXPECT_EQ(refusal(with(2U, 4)), "version");
  EXPECT_EQ(refusal(with(0U, 8)), "count");
  EXPECT_EQ(refusal(with(0x7fffffffU, 8)), "count") << "and nothing is allocated for it";
  EXPECT_EQ(refusal(with(4U, 8)), "size");
  EXPECT_EQ(refusal(bytes.substr(0, bytes.size() - 1)), "size");
  EXPECT_EQ(refusal(bytes + '\0'), "size");
  EXPECT_EQ(refusal(with(2U, kVertices + 4)), "vertex[1]") << "given twice";
  EXPECT_EQ(refusal(with(3U, kVertices + 8)), "vertex[2]") << "out of order";
  EXPECT_EQ(refusal(with(std::numeric_limits<float>::quiet_NaN(), kPlaces)), "place[0]");
  EXPECT_EQ(refusal(with(1.001e3F, kPlaces + 12)), "place[1]");
  EXPECT_EQ(refusal(with(-0.0F, kPlaces + 24)), "place[2]");
}

TEST(MovedVertices, AreAbsoluteSoThatMovingTwiceIsMovingOnce) {
  std::vector<Vec3f> vertices(7, Vec3f(9));
  kMoved.moveIn(vertices);
  kMoved.moveIn(vertices);
  EXPECT_EQ(vertices[2], kMoved.place[0]);
  EXPECT_EQ(vertices[3], Vec3f(9));
  EXPECT_EQ(vertices[6], kMoved.place[2]);
  EXPECT_EQ(kMoved.placeOf(5).value(), kMoved.place[1]);
  EXPECT_FALSE(kMoved.placeOf(4));
  EXPECT_FALSE(kMoved.placeOf(7));
  std::vector<Vec3f> few(3, Vec3f(9));
  kMoved.moveIn(few);
  EXPECT_EQ(few[2], kMoved.place[0]) << "and the others are left out";
}

TEST(MovedVertices, AreThoseThatDiffer) {
  const std::vector<Vec3f> before(7, Vec3f(9));
  std::vector<Vec3f> after = before;
  kMoved.moveIn(after);
  EXPECT_EQ(movedBetween(before, after), kMoved);
  EXPECT_TRUE(movedBetween(before, before).vertex.empty());
}

}  // namespace
}  // namespace haptics::moved_vertices_test
