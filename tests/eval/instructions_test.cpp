#include "tests/eval/instructions.h"

#include <gtest/gtest.h>

namespace haptics::eval::instructions_test {
namespace {

void nops(int count) {
  for (int i = 0; i < count; ++i) asm volatile("nop\n nop\n nop\n nop\n nop\n nop\n nop\n nop");
}

TEST(CountInstructions, CountsEachOne) {
  const double ten = countInstructions([] { nops(10); });
  const double thousand = countInstructions([] { nops(1000); });
  EXPECT_GE(thousand - ten, 990 * 8);
  EXPECT_LE(thousand - ten, 990 * 20);  // the loop's own, also where nothing is optimised
}

TEST(CountInstructions, IsExactlyRepeatable) {
  const auto work = [] { nops(123); };
  EXPECT_EQ(countInstructions(work), countInstructions(work));
}

}  // namespace
}  // namespace haptics::eval::instructions_test
