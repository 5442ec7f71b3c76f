#include "common/crossing/latest_value.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace haptics {
namespace {

struct Large {
  std::array<std::uint64_t, 64> part{};
};

TEST(LatestValue, IsTheNewestAndIsTakenOnce) {
  LatestValue<int> value;
  EXPECT_EQ(value.take(), nullptr);
  for (int i = 1; i < 10; ++i) {
    value.put(10 * i);
    value.put(10 * i + 1);
    const int* taken = value.take();
    ASSERT_NE(taken, nullptr);
    EXPECT_EQ(*taken, 10 * i + 1);
    EXPECT_EQ(value.take(), nullptr);
  }
}

TEST(LatestValue, CrossesThreadsWholeAndInOrder) {
  LatestValue<Large> value;
  constexpr std::uint64_t kValues = 200'000;
  std::thread writer([&] {
    Large large;
    for (std::uint64_t i = 1; i <= kValues; ++i) {
      large.part.fill(i);
      value.put(large);
    }
  });
  std::uint64_t last = 0;
  while (last < kValues) {
    const Large* taken = value.take();
    if (taken == nullptr) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_GT(taken->part[0], last);
    last = taken->part[0];
    for (const std::uint64_t part : taken->part) ASSERT_EQ(part, last);
  }
  writer.join();
}

}  // namespace
}  // namespace haptics
