#include "haptic_server/net/upload_budget.h"

#include <gtest/gtest.h>

namespace haptics::upload_budget_test {
namespace {

constexpr std::size_t kMax_bytes = 100, kMaxOfToken_bytes = 70;
const ContentHash kOne{{1}}, kOther{{2}};

TEST(UploadBudget, LeavesTheOthersAShareThatNobodyWithOneTokenTakes) {
  UploadBudget budget(kMax_bytes, kMaxOfToken_bytes);
  EXPECT_TRUE(budget.reserve(kOne, 40));
  EXPECT_FALSE(budget.reserve(kOne, 31));
  EXPECT_TRUE(budget.reserve(kOne, 30));
  EXPECT_TRUE(budget.reserve(kOther, 30));
}

TEST(UploadBudget, HasNoMoreThanThereIsForAll) {
  UploadBudget budget(kMax_bytes, kMaxOfToken_bytes);
  EXPECT_TRUE(budget.reserve(kOne, 60));
  EXPECT_FALSE(budget.reserve(kOther, 41));
  EXPECT_TRUE(budget.reserve(kOther, 40));
}

TEST(UploadBudget, GivesAgainWhatWasReleased) {
  UploadBudget budget(kMax_bytes, kMaxOfToken_bytes);
  EXPECT_TRUE(budget.reserve(kOne, 70));
  budget.release(kOne, 50);
  EXPECT_FALSE(budget.reserve(kOne, 51));
  EXPECT_TRUE(budget.reserve(kOne, 50));
  budget.release(kOne, 70);
  EXPECT_TRUE(budget.reserve(kOther, 70));
  EXPECT_TRUE(budget.reserve(kOne, 30));
}

}  // namespace
}  // namespace haptics::upload_budget_test
