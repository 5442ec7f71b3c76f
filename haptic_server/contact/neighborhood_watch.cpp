#include "haptic_server/contact/cross_lines.h"
#include "haptic_server/contact/neighborhood_watch_impl.h"

namespace haptics {

template SearchResult neighborhoodWatch<AllCorrections>(const Surface&, const Foot&, Vec3, SearchPath*, int&) noexcept;

/// Most searches by the short way.
template <>
SearchResult neighborhoodWatch<AllCorrections>(const Surface& surface, std::uint32_t start, Vec3 h, SearchPath* path,
                                               int& spent) noexcept {
  const TriangleRecord& record = surface.triangle(start);
  if (!record.zeroArea() && spent + kMostCrossed < kSearchBudget) {
    const std::size_t known = path != nullptr ? path->size() : 0;
    Walk walk{start, Prism(record, all(h))};
    if (crossLines(surface, h, path, walk)) {
      spent += walk.looked;
      const Vec3 foot = vec3(walk.foot);
      return {{walk.triangle, Feature::kPolygon, 0, foot, squaredLength(h - foot)}, true};
    }
    if (path != nullptr) path->keepFirst(known);
  }
  ++spent;
  return neighborhoodWatch(surface, closestOn(record, start, h), h, path, spent);
}

}  // namespace haptics
