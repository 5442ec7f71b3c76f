#pragma once

#include <array>
#include <memory>

#include "tests/eval/analytic_shapes.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"

namespace haptics::eval {

/// What meshes of the shapes are asked for.
inline constexpr std::array kMeshTriangles{12, 192, 768, 3072, 12288, 12 * 74 * 74, 12 * 289 * 289, 12 * 913 * 913};

/// A mesh of an analytic shape.
struct Sample {
  const AnalyticShape& shape;
  TriMesh mesh;
  std::shared_ptr<const CollisionMesh> surface;
};

[[nodiscard]] Sample makeSample(const AnalyticShape& shape, int triangles);

/// Presses at the path's start, strokes along it at 0.1 m/s and constant depth, lifts at its end.
/// @param compare  With a brute-force proxy on the same mesh; takes time in proportion to the triangles.
[[nodiscard]] Record measureAccuracy(const Method& method, const Sample& sample, double depth_m, std::uint64_t seed,
                                     bool compare);

}  // namespace haptics::eval
