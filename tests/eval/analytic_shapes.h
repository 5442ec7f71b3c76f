#pragma once

#include <span>
#include <string_view>

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// What an ideal renderer answers at a place of the HIP. Metres, object frame.
struct Truth {
  Vec3 hip;
  Vec3 ihip;  ///< On the true surface; the HIP when free.
  bool touching;
};

/// A shape whose surface is known exactly, meshes of it, and a path along it.
struct AnalyticShape {
  std::string_view name;
  /// About as many triangles as asked for; every vertex lies on the true surface.
  TriMesh (*mesh)(int triangles);
  /// After `way` metres, 0 to kPath_m, of a path that no mesh line runs along, with the HIP `depth` metres below the
  /// surface (above it: negative).
  Truth (*at)(double way, double depth);
  double radius_m = 0;  ///< Of curvature, where it and the mesh's edges are the same everywhere; else 0.
};

inline constexpr double kPath_m = 0.06;

[[nodiscard]] std::span<const AnalyticShape> analyticShapes();

}  // namespace haptics::eval
