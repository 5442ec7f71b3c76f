#include "haptic_server/engine/step/shape_memory.h"

#include <algorithm>
#include <cmath>

namespace haptics {

ShapeMemory::ShapeMemory(const CollisionMesh& surface, std::span<const Vec3f> vertices)
    : slots_{Slot{surface, {vertices.begin(), vertices.end()}}, Slot{surface, {vertices.begin(), vertices.end()}}} {}

ShapeMemory::Moved ShapeMemory::moveTo(const ShapeSamples& samples, double along,
                                       const CollisionMesh* before) noexcept {
  const bool wasFirst = before == &slots_[0].surface;
  Slot& next = slots_[wasFirst ? 1 : 0];
  const std::vector<Vec3f>& was = slots_[wasFirst ? 0 : 1].vertices;
  const std::size_t segment = along < 1 ? 0 : 1;
  const std::vector<Vec3f>& from = *samples.from_oldest[segment];
  const std::vector<Vec3f>& to = *samples.from_oldest[segment + 1];
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
