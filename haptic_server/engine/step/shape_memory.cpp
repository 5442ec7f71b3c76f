#include "haptic_server/engine/step/shape_memory.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace haptics {

ShapeMemory::ShapeMemory(const CollisionMesh& surface, std::size_t vertices)
    : slots_{Slot{surface, std::vector<Vec3f>(vertices)}, Slot{surface, std::vector<Vec3f>(vertices)}} {
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto vertex = surface.triangle(t).vertexAt(k);
      for (Slot& slot : slots_) slot.vertices[vertex] = Vec3f(surface.triangle(t).corner(k));
    }
  }
}

ShapeMemory::Moved ShapeMemory::moveTo(const ShapeSamples& samples, double along,
                                       const CollisionMesh* before) noexcept {
  const bool wasFirst = before == &slots_[0].surface;
  Slot& next = slots_[wasFirst ? 1 : 0];
  const std::vector<Vec3f>& was = slots_[wasFirst ? 0 : 1].vertices;
  const std::size_t segment = std::min(static_cast<std::size_t>(along), ShapeSamples::kMax - 2);
  const std::vector<Vec3f>& from = *samples.fromOldest[segment];
  const std::vector<Vec3f>& to = *samples.fromOldest[segment + 1];
  const double part = along - static_cast<double>(segment);
  double farthest2 = 0;
  for (std::size_t v = 0; v < next.vertices.size(); ++v) {
    const Vec3f at = part < 1 ? Vec3f(glm::mix(Vec3(from[v]), Vec3(to[v]), part)) : to[v];
    next.vertices[v] = at;
    farthest2 = std::max(farthest2, squaredLength(Vec3(at) - Vec3(was[v])));
  }
  next.surface.moveVertices(next.vertices);
  return {&next.surface, std::sqrt(farthest2)};
}

}  // namespace haptics
