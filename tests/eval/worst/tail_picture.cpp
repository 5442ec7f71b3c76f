#include "tests/eval/worst/tail_picture.h"

#include <array>
#include <cmath>
#include <string_view>

#include "tests/eval/figure/figure.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"

namespace haptics::eval {
namespace {

constexpr std::array<std::string_view, 4> kBaselines{"pseudocode_closed", "god_object", "finite_proxy_1mm",
                                                     "global_closest"};

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
  Record all = Record::array();
  for (const Tail& tail : tails)
    all.push_back({{"name", tail.name}, {"method", tail.method}, {"survival", tail.survival}});
  drawFigure("worst", {{"tails", std::move(all)}, {"limit_us", limit_us}}, folder / "worst");
}

}  // namespace haptics::eval
