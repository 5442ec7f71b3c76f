#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/mesh/tri_mesh.h"

/// Ways to answer the same questions, timed against each other.
namespace haptics::bench {

/// One way.
struct Contestant {
  std::string name;
  /// Answers every question of the course once; returns the mean of the answers (a distance or time), which all
  /// contestants must agree on.
  std::function<double()> lap;
};
using Contestants = std::vector<Contestant>;

/// Registers a benchmark that lets the contestants run laps in turn, so that a noisy machine disturbs all alike, two
/// each: one with caches that hold what the others read, one right after with its own. Reports `<name>_ns`, the median
/// over the latter of the mean time per question, `<name>_over_<first name>`, the median of their ratios within a
/// round, and `<name>_after_others_ns`, the median over the former. `make` is called when the benchmark runs; it also returns the number of questions.
struct Course {
  std::size_t questions = 0;
  Contestants contestants;
  double tolerance = 0;  ///< Between the answers of the first and any other, relative to the first's.
};
void registerContest(const std::string& name, std::function<Course()> make);

}  // namespace haptics::bench
