#include "common/mesh/triangle_distance.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace haptics {
namespace {

double squaredDistanceToSide(Vec3 place, Vec3 from, Vec3 to) {
  const Vec3 along = to - from;
  const double part = glm::clamp(glm::dot(place - from, along) / squaredLength(along), 0.0, 1.0);
  return squaredLength(place - from - along * part);
}

}  // namespace

double squaredDistance(Vec3 place, const std::array<Vec3, 3>& corner) {
  const Vec3 normal = areaNormal(corner);
  bool isAboveTriangle = true;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 a = corner[k], b = corner[(k + 1) % 3];
    isAboveTriangle = isAboveTriangle && glm::dot(glm::cross(normal, b - a), place - a) >= 0;
    least = std::min(least, squaredDistanceToSide(place, a, b));
  }
  const double height = glm::dot(normal, place - corner[0]);
  return isAboveTriangle ? height * height / squaredLength(normal) : least;
}

}  // namespace haptics
