#include "common/mailbox/triple_buffer.h"

#include <gtest/gtest.h>

#include <thread>

namespace haptics::test::triple_buffer_test {
namespace {

struct Pair {
  std::uint64_t a = 0, b = 0;
  std::array<std::uint64_t, 14> rest{};
};

TEST(TripleBuffer, IsEmptyAtFirstAndThenTheLastThatWasPut) {
  TripleBuffer<int> box;
  EXPECT_EQ(box.newest(), 0);
  box.put(1);
  box.put(2);
  EXPECT_EQ(box.newest(), 2);
  EXPECT_EQ(box.newest(), 2) << "it stays";
  box.put(3);
  EXPECT_EQ(box.newest(), 3);
}

TEST(TripleBuffer, IsTakenOnce) {
  TripleBuffer<int> box;
  EXPECT_EQ(box.takeNew(), nullptr);
  box.put(1);
  box.put(2);
  ASSERT_NE(box.takeNew(), nullptr);
  EXPECT_EQ(box.takeNew(), nullptr);
  EXPECT_EQ(box.newest(), 2);
}

TEST(TripleBuffer, IsNeverTornAndNeverGoesBackBetweenThreads) {
  TripleBuffer<Pair> box;
  constexpr std::uint64_t kPuts = 300'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kPuts; ++i) {
      Pair pair{i, ~i, {}};
      pair.rest.fill(i);
      box.put(pair);
    }
  });
  std::uint64_t last = 0;
  while (last < kPuts) {
    const Pair pair = box.newest();
    if (pair.a == 0) continue;
    ASSERT_EQ(pair.b, ~pair.a);
    for (const std::uint64_t value : pair.rest) ASSERT_EQ(value, pair.a);
    ASSERT_GE(pair.a, last);
    last = pair.a;
  }
  writer.join();
}

}  // namespace
}  // namespace haptics::test::triple_buffer_test
