#pragma once

#include <optional>

#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// A mesh for one object, judged against the scene's own by the same strokes in the same scene.
struct Candidate {
  std::shared_ptr<const Surface> surface;
  std::size_t triangles = 0;
  double deviation_mm = 0;  ///< Largest, of a vertex of the scene's own mesh from this one.
  double epsilon_p99 = 0;   ///< Force error in what a hand can notice, not exceeded in 99 % of the ticks.
  double epsilon_max = 0;
  int ticks = 0;
  int missedTicks = 0;     ///< Without contact where the scene's own mesh has one, for more than one tick on end.
  int wrongSideTicks = 0;  ///< Pushed the other way.
  bool strayed = false;    ///< Farther from the scene's own mesh than the tolerance.
  bool opened = false;     ///< The mesh has an inside no more.
  double hot_ns = 0;       ///< Contact tick on the strokes, median.
  double cold_ns = 0;      ///< The same with every cache swept.
  double memory_MB = 0;

  [[nodiscard]] bool safe() const noexcept { return missedTicks == 0 && wrongSideTicks == 0 && !opened && !strayed; }
  [[nodiscard]] bool good() const noexcept { return safe() && epsilon_p99 < 1; }
};

/// The scene's own mesh first, then copies, each with 0.7 of the triangles of the one before, until two on end will not
/// do.
/// @param tolerance  How far a copy may stray from the scene's own mesh, as a part of the object's longest side.
[[nodiscard]] std::vector<Candidate> candidatesFor(const std::vector<LoadedObject>& scene, std::size_t object,
                                                   const std::vector<HandStroke>& strokes, double tolerance);

}  // namespace haptics::eval
