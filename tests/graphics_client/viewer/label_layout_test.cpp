#include "graphics_client/viewer/label_layout.h"

#include <gtest/gtest.h>

namespace haptics::label_layout_test {
namespace {

constexpr double kWidth = 60, kHeight = 16;

LabelWish at(double x, double y) { return {.x = x, .y = y, .width = kWidth, .height = kHeight, .named = {x, y, 0, 0}}; }

bool apart(const PixelBox& a, const PixelBox& b) {
  return a.left + a.width < b.left || b.left + b.width < a.left || a.bottom + a.height < b.bottom ||
         b.bottom + b.height < a.bottom;
}

TEST(LabelLayout, PutsALabelRightBelowWhatItNames) {
  const std::vector<LabelWish> wishes = {at(200, 300)};
  const auto places = placeLabels(wishes, {});
  ASSERT_TRUE(places[0]);
  EXPECT_DOUBLE_EQ(places[0]->left + kWidth / 2, 200);
  EXPECT_LT(places[0]->bottom + kHeight, 300);
  EXPECT_GT(places[0]->bottom + kHeight, 300 - kHeight / 2);
}

TEST(LabelLayout, LetsNoTwoLabelsOverlap) {
  std::vector<LabelWish> wishes;
  for (int i = 0; i < 40; ++i) wishes.push_back(at(100 + 13 * (i % 7), 200 + 5 * (i % 11)));
  const auto places = placeLabels(wishes, {});
  int shown = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i]) continue;
    ++shown;
    for (std::size_t j = 0; j < i; ++j) EXPECT_TRUE(!places[j] || apart(*places[i], *places[j])) << i << " " << j;
  }
  EXPECT_GT(shown, 3);
}

TEST(LabelLayout, GivesWayToANeighbourByGoingLower) {
  const std::vector<LabelWish> wishes = {at(200, 300), at(220, 301)};
  const auto places = placeLabels(wishes, {});
  ASSERT_TRUE(places[0] && places[1]);
  EXPECT_LT(places[1]->bottom, places[0]->bottom);
}

TEST(LabelLayout, StaysOnTheEdgeOfWhatItNamesWhereSomethingElseIsBelow) {
  std::vector<LabelWish> wishes = {at(200, 300), at(200, 200)};
  wishes[0].named = {150, 300, 100, 80};
  wishes[1].named = {150, 200, 100, 90};
  const auto places = placeLabels(wishes, {});
  ASSERT_TRUE(places[0] && places[1]);
  EXPECT_DOUBLE_EQ(places[0]->bottom + kHeight / 2, 300);
  EXPECT_LT(places[1]->bottom + kHeight, 200);
}

TEST(LabelLayout, LeavesOutALabelThatWouldHideACard) {
  const std::vector<PixelBox> panel = {{150, 200, 100, 200}};
  const std::vector<LabelWish> wishes = {at(200, 300), at(400, 300)};
  const auto places = placeLabels(wishes, panel);
  EXPECT_FALSE(places[0]);
  EXPECT_TRUE(places[1]);
}

}  // namespace
}  // namespace haptics::label_layout_test
