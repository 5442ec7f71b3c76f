#pragma once

#include <filesystem>

namespace haptics::eval {

struct Table1Options {
  double seconds = 10;      ///< For each object, in all.
  int runs = 1;             ///< Of that length; the paper has 3 of 3 minutes.
  int finest = 10'100'000;  ///< No objects of more triangles.
  std::filesystem::path out = ".";
};

/// The paper's Table I: rates of the servo loop, flat out, with the real viewer connected, by the polygons of the object.
/// The paper's four objects and spheres of 1 and 10 million triangles; the HIP goes the same way over each, 0.1 mm to a
/// tick, from a recording. The complete step, device to force and telemetry, is that of the server; the bare step is
/// followContact() alone. The paper's objects take turns of at most 2 s, so that what else the machine does falls on all
/// alike; the ratios are medians over the turns, of ticks in a second of the servo thread's own time, which other programs
/// do not take from it. Writes DIR/table1.json after each turn, so that an early end leaves what was measured by then,
/// marked as not `complete`; prints the table at the end.
/// `pass` of 64,800 polygons: a complete step at no less than 0.9 of the rate at 12 polygons.
/// @return Whether it was measured to the end: contact held, and the viewer proved each time that it held the same scene.
/// The ratio does not count here: it is no test of a busy machine.
[[nodiscard]] bool runTable1(const Table1Options& options);

}  // namespace haptics::eval
