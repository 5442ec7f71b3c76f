#include "graphics_client/viewer/label_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace haptics {
namespace {

/// Between a label and what it names, and between labels (pixels).
constexpr double kGap_px = 3;
/// A label goes down by this many of its heights at most: farther off it would seem to name something else.
constexpr int kMostSteps = 1;

bool overlap(const PixelBox& a, const PixelBox& b) {
  return a.left < b.left + b.width + kGap_px && b.left < a.left + a.width + kGap_px &&
         a.bottom < b.bottom + b.height + kGap_px && b.bottom < a.bottom + a.height + kGap_px;
}

}  // namespace

std::vector<std::optional<PixelBox>> placeLabels(std::span<const LabelWish> wishes, std::span<const PixelBox> taken) {
  std::vector<std::size_t> order(wishes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return wishes[i].y; });
  std::vector<PixelBox> occupied(taken.begin(), taken.end());
  std::vector<std::optional<PixelBox>> places(wishes.size());
  for (const std::size_t i : order) {
    const LabelWish& wish = wishes[i];
    for (int step = 0; step <= kMostSteps; ++step) {
      const double down = wish.height + kGap_px + step * (wish.height + 2 * kGap_px);
      const PixelBox box{std::round(wish.x - wish.width / 2), std::round(wish.y - down), wish.width, wish.height};
      if (std::ranges::any_of(occupied, [&](const PixelBox& other) { return overlap(box, other); })) continue;
      places[i] = box;
      occupied.push_back(box);
      break;
    }
  }
  return places;
}

}  // namespace haptics
