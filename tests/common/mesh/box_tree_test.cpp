#include "common/mesh/box_tree.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>

namespace haptics::box_tree_test {
namespace {

bool holds(const Box& outer, const Box& inner) {
  return glm::all(glm::lessThanEqual(outer.low, inner.low)) && glm::all(glm::greaterThanEqual(outer.high, inner.high));
}

void expectSound(const BoxTree& tree, const std::vector<Box>& boxes, std::size_t node,
                 std::multiset<std::uint32_t>& seen) {
  if (!tree.isLeaf(node)) {
    for (const std::size_t child : {2 * node, 2 * node + 1}) {
      EXPECT_TRUE(holds(tree.box(node), tree.box(child)));
      expectSound(tree, boxes, child, seen);
    }
    return;
  }
  EXPECT_LE(tree.leaf(node).size(), BoxTree::kMaxInLeaf);
  for (const std::uint32_t item : tree.leaf(node)) {
    EXPECT_TRUE(holds(tree.box(node), boxes[item]));
    seen.insert(item);
  }
}

std::vector<Box> someBoxes(std::size_t count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> place(-1, 1);
  std::vector<Box> boxes(count);
  for (Box& box : boxes) {
    for (int i = 0; i < 2; ++i) {
      const Vec3f at(place(random), place(random), place(random));
      box.join({at, at});
    }
  }
  return boxes;
}

TEST(BoxTree, HoldsEveryItemOnceInBoxesAboutIt) {
  for (const std::uint32_t count : {0U, 1U, 8U, 9U, 17U, 1000U}) {
    std::vector<Box> boxes = someBoxes(count);
    BoxTree tree(count, [&](std::uint32_t item) { return boxes[item]; });
    std::multiset<std::uint32_t> seen;
    expectSound(tree, boxes, BoxTree::kRoot, seen);
    EXPECT_EQ(seen.size(), count);
    EXPECT_EQ(std::set(seen.begin(), seen.end()).size(), count);
    for (std::uint32_t item = 0; item < count; item += 5) {
      boxes[item].high += 10.0F;
      tree.refit(std::array{item});
    }
    seen.clear();
    expectSound(tree, boxes, BoxTree::kRoot, seen);
  }
}

TEST(BoxTree, PartsItemsWhoseSizesDifferByManyDecades) {
  constexpr std::uint32_t kCount = 1024;
  const auto boxOf = [](std::uint32_t item) {  // shuffled; each begins where all smaller ones end
    const float at = std::pow(10.0F, -35 * static_cast<float>(item * 389 % kCount) / kCount);
    return Box{Vec3f(0.99F * at, 0, 0), Vec3f(at, at, at)};
  };
  const BoxTree tree(kCount, boxOf);
  std::size_t meetings = 0;
  constexpr std::size_t kFirstLeaf = kCount / BoxTree::kMaxInLeaf;
  ASSERT_TRUE(tree.isLeaf(kFirstLeaf));
  for (std::size_t a = kFirstLeaf; a < 2 * kFirstLeaf; ++a) {
    for (std::size_t b = kFirstLeaf; b < a; ++b) meetings += tree.box(a).meets(tree.box(b)) ? 1U : 0U;
  }
  EXPECT_LE(meetings, 256U) << "of 8,128";
}

}  // namespace
}  // namespace haptics::box_tree_test
