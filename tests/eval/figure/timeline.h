#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/error/error.h"
#include "tests/eval/figure/figure.h"

namespace haptics::eval {

struct TimeBand {
  double from_s, to_s;
  Colour colour;
};

struct TimeCurve {
  std::string name;
  Colour colour;
  std::vector<std::pair<double, double>> points;  ///< (s, value); a value below the decades lies on the rim.
};

/// Logarithmic in y.
struct TimePanel {
  std::string title;
  Decades y;
  std::vector<TimeCurve> curves;
};

/// Panels one below another over the same time.
struct Timeline {
  std::string title;
  std::vector<std::string> caption;
  double seconds = 0;
  std::vector<TimeBand> bands;                         ///< Behind all panels.
  std::vector<std::pair<double, std::string>> events;  ///< (s, what), above the panels.
  std::vector<TimePanel> panels;
};

/// As drawFigure().
[[nodiscard]] Result<void> drawTimeline(const Timeline& timeline, const std::filesystem::path& png,
                                        const std::filesystem::path& svg);

}  // namespace haptics::eval
