#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/eval/combinations/pair.h"

namespace haptics::eval {

/// A pair as the picture shows it.
struct SheetPair {
  Feature row, column;
  std::vector<std::pair<Measure, double>> worst;
  std::string plotted;
  std::vector<std::pair<double, double>> felt, right;  ///< Of the seed that came nearest to a limit, or beyond.
};

/// The matrix of the features: a plot of each pair above the diagonal, its measures beside their limits below, into STEM.png.
void drawCombinations(const std::vector<SheetPair>& pairs, const std::string& method, int seeds,
                      const std::filesystem::path& stem);

}  // namespace haptics::eval
