#pragma once

#include <span>
#include <string_view>

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// A point of the true surface, metres, object frame.
struct SurfacePoint {
  Vec3 place;
  Vec3 normal;  ///< Unit, outward.
};

/// A shape whose surface is known exactly, meshes of it, and a path along it.
struct AnalyticShape {
  std::string_view name;
  /// About as many triangles as asked for; every vertex lies on the true surface.
  TriMesh (*mesh)(int triangles);
  /// After `way` metres, 0 to kPath_m, of a path that no mesh line runs along.
  SurfacePoint (*at)(double way);
};

inline constexpr double kPath_m = 0.06;

[[nodiscard]] std::span<const AnalyticShape> analyticShapes();

}  // namespace haptics::eval
