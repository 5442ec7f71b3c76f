#include "tests/eval/worst/tail_picture.h"

#include <array>
#include <cmath>
#include <string_view>

#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/methods.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

constexpr std::array kColours{Colour{0.0, 0.447, 0.698}, Colour{0.835, 0.369, 0.0}, Colour{0.0, 0.62, 0.451},
                              Colour{0.8, 0.475, 0.655}, Colour{0.902, 0.624, 0.0}, Colour{0.337, 0.706, 0.914},
                              Colour{0.55, 0.57, 0.60},  Colour{0.60, 0.31, 0.64},  Colour{0.40, 0.26, 0.13},
                              Colour{0.69, 0.69, 0.10},  Colour{0.10, 0.10, 0.10},  Colour{0.80, 0.10, 0.25}};
constexpr std::array<std::string_view, 4> kBaselines{"pseudocode_closed", "god_object", "finite_proxy_1mm",
                                                     "global_closest"};

/// In a panel.
std::vector<CurvePoint> curveOf(const Tail& tail) {
  std::vector<CurvePoint> points;
  for (const auto& [us, part] : tail.survival) points.push_back({us, part, ""});
  return points;
}

}  // namespace

std::vector<std::pair<double, double>> survivalOf(Statistics& durations_ns) {
  std::vector<std::pair<double, double>> points;
  if (durations_ns.empty()) return points;
  const double least = 1 / static_cast<double>(durations_ns.count());
  for (double above = 1; above >= least; above /= std::sqrt(std::sqrt(10.0)))
    points.emplace_back(durations_ns.quantile(1 - above) / 1e3, above);
  points.emplace_back(durations_ns.max() / 1e3, least);
  return points;
}

std::vector<Tail> baselineTails(const std::vector<std::pair<const Family*, Genome>>& worst, int ticks) {
  std::vector<Tail> tails;
  for (const std::string_view name : kBaselines) {
    Statistics durations_ns;
    for (const auto& [family, genome] : worst) {
      const auto method = findMethod(name, methods()).make();
      for (const double ns : playWith(*method, *family->make(genome.scene), genome, ticks)) durations_ns.add(ns);
    }
    tails.push_back({std::string(name), "baseline", survivalOf(durations_ns)});
  }
  return tails;
}

void drawTails(const std::vector<Tail>& tails, double limit_us, const std::filesystem::path& folder) {
  Figure figure;
  figure.title = "How long ticks take where a hunter looks for the slowest";
  char limit[80];
  std::snprintf(limit, sizeof limit, "A tick of ours may take the instructions of %.0f us.", limit_us);
  figure.caption = {limit, "Times of this machine, with what else it did meanwhile."};
  figure.columns = 2;
  figure.legendTitle = "Scenes, methods";
  const Decades time{-2, 5};
  const Decades part{-6, 0};
  Panel ours{"ours, by scene", "tick, us", "part of the ticks that takes longer", time, part, {}, {}};
  Panel others{
      "baselines, in the worst of ours", "tick, us", "part of the ticks that takes longer", time, part, {}, {}};
  for (std::size_t i = 0; i < tails.size(); ++i) {
    if (tails[i].survival.empty()) continue;
    const bool isOurs = tails[i].method == "ours";
    figure.styles.push_back(
        {tails[i].name, tails[i].method, kColours[i % kColours.size()], isOurs ? Marker::kDisc : Marker::kCross});
    (isOurs ? ours : others).curves.push_back({figure.styles.size() - 1, curveOf(tails[i])});
  }
  figure.panels = {ours, others};
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawFigure(figure, folder / "worst.png", folder / "worst.svg"));
}

}  // namespace haptics::eval
