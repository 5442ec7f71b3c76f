#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tests/eval/closed_loop_rest.h"
#include "tests/eval/instruction_cost.h"
#include "tests/eval/methods.h"

namespace haptics::eval {

/// A method on meshes of about as many triangles: six shapes, 2 mm deep at 0.1 m/s.
struct ChartPoint {
  std::string method;
  int triangles;            ///< Asked for.
  double epsilon;           ///< Not exceeded in 99 % of a shape's ticks; of the worst shape.
  double above100Hz_rms_N;  ///< Force that the surface does not have; of the worst shape.
  ClosedLoopRest rest;      ///< Of the worst shape.
  InstructionCost price;    ///< Medians over the shapes; instructions on the sphere.
};

/// In order of triangles, then of the methods. Where one from outside crashes or the like it has no point, which is printed.
[[nodiscard]] std::vector<ChartPoint> measureChartPoints(std::span<const Method> methods, std::uint64_t seed,
                                                         int finest);

/// How a method does in the failure scenes that it can be put into. By a fault of its own it fails.
struct Outcome {
  std::vector<std::string_view> passed;
  std::vector<std::string_view> failed;
};
[[nodiscard]] Outcome outcomeOf(const Method& method, std::uint64_t seed);

}  // namespace haptics::eval
