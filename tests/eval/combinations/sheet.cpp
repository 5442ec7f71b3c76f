#include "tests/eval/combinations/sheet.h"

#include <cstdio>

#include "tests/eval/combinations/limits.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/report.h"

namespace haptics::eval {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, kFeatures> kTitles{{
    {"Texture", "waves, Eq. (4), K = 1.5"},
    {"Force shading", "sphere, 1,728 triangles"},
    {"Friction map", "stick, slide, 4 waves"},
    {"Softness", "springs in series"},
    {"Plastic", "a dent that stays"},
    {"Lattice", "free-form deformation"},
    {"Motion", "slides against a spring"},
    {"Several surfaces", "groove of two bodies"},
    {"Effects", "springs to a point and a line"},
}};

/// Short: beside a bar.
std::string numberText(double value) {
  constexpr double kMin = 0.01, kFew = 1, kWhole = 10;
  if (value > 0 && value < kMin) return "<0.01";
  char text[32];
  std::snprintf(text, sizeof text, value < kFew ? "%.2f" : value < kWhole ? "%.1f" : "%.0f", value);
  return text;
}

}  // namespace

void drawCombinations(const std::vector<SheetPair>& pairs, const std::string& method, int seeds,
                      const std::filesystem::path& stem) {
  Record all = Record::array();
  for (const SheetPair& pair : pairs) {
    Record bars = Record::array();
    for (const auto& [measure, value] : pair.worst) {
      const Limit& limit = limitOf(measure);
      if (measure == Measure::kBadTicks && value == 0) continue;
      const double share = limit.most > 0 ? value / limit.most : value > 0 ? 2 : 0;
      bars.push_back({limit.shown, share, numberText(value / limit.unit)});
    }
    all.push_back({{"row", static_cast<std::size_t>(pair.row)},
                   {"column", static_cast<std::size_t>(pair.column)},
                   {"title", std::string(nameOf(pair.row)) + " + " + std::string(nameOf(pair.column))},
                   {"plotted", pair.plotted},
                   {"felt", pair.felt},
                   {"right", pair.right},
                   {"bars", std::move(bars)}});
  }
  const std::string caption = "Ho, Basdogan & Srinivasan (1999), sections 4 and 5, by " + method +
                              ", against exact references that share no code with it.";
  const std::string below =
      "Above the diagonal: felt and right along a stroke, of the seed that came nearest to a limit. Below: the worst "
      "of " +
      std::to_string(seeds) + (seeds == 1 ? " seed" : " seeds") + "; a bar ends at its limit.";
  drawFigure("combinations", {{"features", kTitles}, {"caption", {caption, below}}, {"pairs", std::move(all)}}, stem);
}

}  // namespace haptics::eval
