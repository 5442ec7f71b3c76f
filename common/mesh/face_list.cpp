#include "common/mesh/face_list.h"

#include <cmath>
#include <limits>
#include <string>

namespace haptics {

const char* faultOf(const Vec3& vertex) {
  if (!isFinite(vertex)) return "is not finite";
  constexpr double kLargest = std::numeric_limits<float>::max();
  return glm::all(glm::lessThanEqual(glm::abs(vertex), Vec3(kLargest))) ? nullptr : "does not fit into float32";
}

Result<void> addFace(std::span<const std::uint32_t> corners, std::uint64_t line, PolygonSoup& soup) {
  for (const std::uint32_t corner : corners) {
    const char* const fault = corner < soup.vertices.size() ? faultOf(soup.vertices[corner]) : nullptr;
    if (fault == nullptr) continue;
    return refused("", (line > 0 ? "line " + std::to_string(line) + ": the face's vertex " : "a face's vertex ") +
                           std::to_string(corner) + " (from 0) " + fault);
  }
  soup.addPolygon(corners);
  return {};
}

Result<void> FaceList::addTo(PolygonSoup& soup) const {
  std::span<const std::uint32_t> rest = corners_;
  for (const Face& face : faces_) {
    if (auto ok = addFace(rest.first(face.corners), face.line, soup); !ok) return ok;
    rest = rest.subspan(face.corners);
  }
  return {};
}

}  // namespace haptics
