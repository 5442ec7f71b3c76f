#pragma once

#include "tests/eval/report.h"
#include "tests/eval/statistics.h"
#include "tests/eval/table1/paper_objects.h"

namespace haptics::eval {

/// Of one object, block by block.
struct Rates {
  Statistics complete_kHz;   ///< On the wall's clock.
  Statistics processor_kHz;  ///< On the servo thread's own.
  Statistics ratio;          ///< Of the latter to the first object's in the same turn.
  Statistics bare_kHz;       ///< followContact() alone, on its thread's own clock.
  Statistics bareRatio;
  double contactTicks = 0;
  double ticks = 0;
  bool viewerHeld = true;

  [[nodiscard]] bool begun() const noexcept { return ticks > 0; }
  /// Contact held, and the viewer proved each time that it held the same scene.
  [[nodiscard]] bool measured() const noexcept;
};

/// What is as it was for all objects.
struct Table1Run {
  double viewer_Hz = 0;  ///< Frames; 0 while it runs.
  bool complete = true;  ///< Not ended early.
};

/// `pass` of 64,800 polygons: the median ratio is no less than 0.9.
[[nodiscard]] Record describe(const TableObject& object, Rates& rates, const Table1Run& run);
void printTable(const std::vector<Record>& records);

}  // namespace haptics::eval
