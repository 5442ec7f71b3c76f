#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "tests/eval/figure/canvas.h"

namespace haptics::eval {

/// A drawing of its own kind, in pixels from its lower left corner. Strokes are drawn in their order, then dots, then words.
struct DrawnPanel {
  static constexpr double kWidth_px = 440;
  static constexpr double kHeight_px = 330;

  struct Stroke {
    std::vector<Canvas::Point> points;
    Colour colour;
    double width = 1;
  };
  struct Dot {
    Canvas::Point at;
    double radius = 2;
    Colour colour;
  };
  struct Words {
    Canvas::Point at;
    std::string text;
    Align align = Align::kLeft;
  };

  std::string heading;
  std::string verdict;               ///< Under the heading.
  std::optional<Raster> background;  ///< As large as the panel.
  std::vector<Stroke> strokes;
  std::vector<Dot> dots;
  std::vector<Words> words;
};

struct PairKey {
  std::string meaning;
  Colour colour;
  bool stroke = false;  ///< A line rather than a dot.
};

/// Two panels side by side, a title above and what the colours mean below.
struct PanelPair {
  std::string title;
  std::array<DrawnPanel, 2> panels;
  std::vector<PairKey> key;
};

/// A PNG, by VTK. Needs an X display: VirtualDisplay::ensure(). Refused: a file that cannot be written.
[[nodiscard]] Result<void> drawPanelPair(const PanelPair& pair, const std::filesystem::path& png);

}  // namespace haptics::eval
