#include "haptic_server/scene/fit_mapping.h"

#include <limits>

namespace haptics {
namespace {

/// A flat mesh has no thickness, and a mapping's box needs one.
constexpr double kMinMappingSide_m = 1e-6;

struct Box {
  Vec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
};

Box boxOf(const TriMesh& mesh, const Quat& toFrame) {
  Box box;
  for (const Vec3f& vertex : mesh.vertices) {
    const Vec3 at = toFrame * Vec3(vertex);
    box.low = glm::min(box.low, at);
    box.high = glm::max(box.high, at);
  }
  return box;
}

}  // namespace

void fitToMesh(const MappedSource& source, const TriMesh& mesh, Mapping& mapping) {
  if (!source.centreOfMesh && !source.sizeOfMesh) return;
  const Box box = boxOf(mesh, glm::conjugate(mapping.rotation));
  if (source.centreOfMesh) mapping.centre = mapping.rotation * ((box.low + box.high) / 2.0);
  if (source.sizeOfMesh) mapping.size_m = glm::max(box.high - box.low, Vec3(kMinMappingSide_m));
}

}  // namespace haptics
