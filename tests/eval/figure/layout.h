#pragma once

#include <cstddef>

// Sizes of a figure in pixels; the origin is below on the left.
namespace haptics::eval::layout {

inline constexpr double kPanelWidth = 400, kPanelHeight = 360;
inline constexpr double kLeft = 118;   ///< Of a panel: room for the numbers and the label of y.
inline constexpr double kBelow = 100;  ///< Of a panel: numbers and label of x.
inline constexpr double kGap = 30;     ///< Right of a panel.
inline constexpr double kTitle = 44;   ///< Above a panel.
inline constexpr double kHeader = 70;  ///< The figure's title.
inline constexpr double kLine = 30;    ///< Of the caption.
inline constexpr double kLegend = 490;
inline constexpr double kLegendTitle = 70;
inline constexpr double kEntry = 72;  ///< Of the legend.

inline constexpr int kTitleFont = 36, kTextFont = 24, kSmallFont = 21;

[[nodiscard]] constexpr double cellWidth() { return kLeft + kPanelWidth + kGap; }
[[nodiscard]] constexpr double cellHeight() { return kTitle + kPanelHeight + kBelow; }

}  // namespace haptics::eval::layout
