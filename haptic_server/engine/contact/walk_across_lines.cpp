#include "haptic_server/engine/contact/walk_across_lines.h"

#include <limits>

namespace haptics {
namespace {

/// Triangles that a walk looks at before the general search takes over.
constexpr int kMaxCrossed = 16;

/// From triangle to triangle across the lines that are closest to h, with the bits of the general search.
struct Walk {
  enum class End {
    kHeld,      ///< The prism over the triangle holds h.
    kAtVertex,  ///< A vertex of the triangle is the closest so far: the search goes on around it.
    kUnclear,   ///< At a boundary, at a triangle without area, or where nothing is closer than a line.
  };

  std::uint32_t triangle;
  int looked = 1;  // triangles
  Vec3 foot{0};    // kHeld: of h

  [[gnu::always_inline]] End go(const CollisionMesh& surface, Vec3 h, SearchPath* path) noexcept {
    const Vec3x4 each = broadcast(h);
    double nearest = std::numeric_limits<double>::infinity();  // squared distance, m^2
    while (true) {
      const TriangleRecord& record = surface.triangle(triangle);
      if (record.zeroArea() || looked > kMaxCrossed) return End::kUnclear;
      const Prism prism(record);
      const Prism::Coordinates place = prism.coordinates(each);
      const unsigned beyond = place.beyond();
      if (beyond == 0) {
        foot = vec3(prism.foot(toDouble4(h), place.height()));
        if (path != nullptr) path->add(foot, triangle);
        return squaredLength(h - foot) < nearest ? End::kHeld : End::kUnclear;
      }
      const Prism::OnEdges on = prism.onEdges(each);
      const int k = on.nearest(beyond);
      if (!(on.squaredDistance[k] < nearest) || record.neighbour(k) == kNoTriangle) return End::kUnclear;
      if (on.atCorner(k)) return End::kAtVertex;
      nearest = on.squaredDistance[k];
      if (path != nullptr) path->add(on.point[k], triangle);
      triangle = record.neighbour(k);
      ++looked;
    }
  }
};

}  // namespace

bool walkAcrossLines(const CollisionMesh& surface, std::uint32_t& start, Vec3 h, SearchRun& run,
                     SearchResult& found) noexcept {
  if (run.looked + kMaxCrossed >= run.budget) return false;
  SearchPath* const path = run.path;
  const std::size_t known = path != nullptr ? path->size() : 0;
  Walk walk{start};
  const Walk::End end = walk.go(surface, h, path);
  if (end == Walk::End::kHeld) {
    run.looked += walk.looked;
    found = {{walk.triangle, Feature::kPolygon, 0, walk.foot, squaredLength(h - walk.foot)}, true};
    return true;
  }
  if (end == Walk::End::kAtVertex) {
    start = walk.triangle;
    run.looked += walk.looked - 1;
  } else if (path != nullptr) {
    path->keepFirst(known);
  }
  return false;
}

}  // namespace haptics
