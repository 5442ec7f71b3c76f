#include "haptic_server/engine/geometry/simd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace haptics::simd_test {
namespace {

TEST(Simd, TheMaximumOfEqualsIsTheSecond) {
  EXPECT_TRUE(std::signbit(maximum(broadcast(0.0), broadcast(-0.0))[0]));
  EXPECT_FALSE(std::signbit(maximum(broadcast(-0.0), broadcast(0.0))[2]));
}

TEST(Simd, TheMaximumWithWhatIsNotANumberIsTheSecond) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(maximum(broadcast(kNan), broadcast(1))[0], 1);
  EXPECT_TRUE(std::isnan(maximum(broadcast(1), broadcast(kNan))[2]));
}

TEST(Simd, TheMaximumOfDifferentNumbersIsTheGreater) {
  EXPECT_EQ(maximum(broadcast(-2), broadcast(1))[0], 1);
  EXPECT_EQ(maximum(broadcast(3), broadcast(1))[2], 3);
}

}  // namespace
}  // namespace haptics::simd_test
