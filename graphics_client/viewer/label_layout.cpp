#include "graphics_client/viewer/label_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace haptics {
namespace {

/// Between a label and what it names, and between labels (pixels).
constexpr double kGap_px = 3;

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
    const auto at = [&](double down) {
      return PixelBox{std::round(wish.x - wish.width / 2), std::round(wish.y - down), wish.width, wish.height};
    };
    const PixelBox below = at(wish.height + kGap_px), astride = at(wish.height / 2),
                   lower = at(2 * wish.height + 3 * kGap_px);
    const auto hidesOthers = [&](const PixelBox& box) {
      for (std::size_t other = 0; other < wishes.size(); ++other) {
        if (other != i && overlap(box, wishes[other].named)) return true;
      }
      return false;
    };
    const PixelBox first = hidesOthers(below) ? astride : below;
    for (const PixelBox& box : {first, lower}) {
      if (std::ranges::any_of(occupied, [&](const PixelBox& other) { return overlap(box, other); })) continue;
      places[i] = box;
      occupied.push_back(box);
      break;
    }
  }
  return places;
}

}  // namespace haptics
