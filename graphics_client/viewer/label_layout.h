#pragma once

#include <optional>
#include <span>
#include <vector>

namespace haptics {

/// A rectangle in the window, in pixels from its lower left corner.
struct PixelBox {
  double left = 0, bottom = 0, width = 0, height = 0;

  bool operator==(const PixelBox&) const = default;
};

/// A label's size, the middle of the lower edge of what it names, and all of that.
struct LabelWish {
  double x = 0, y = 0;
  double width = 0, height = 0;
  PixelBox named = {};
};

/// Places each label just below what it names; on its lower edge where another one's thing is below; a little lower
/// where another label is; nothing where it would hide another label or something that is `taken`. What is lower in the
/// window comes first.
[[nodiscard]] std::vector<std::optional<PixelBox>> placeLabels(std::span<const LabelWish> wishes,
                                                               std::span<const PixelBox> taken);

}  // namespace haptics
