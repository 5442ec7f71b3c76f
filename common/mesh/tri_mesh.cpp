#include "common/mesh/tri_mesh.h"

#include <bit>
#include <cmath>
#include <string>

#include "common/interruption/interruption.h"

namespace haptics {
namespace {

std::string item(const char* list, std::size_t i) { return std::string(list) + '[' + std::to_string(i) + ']'; }

bool isNegativeZero(float x) { return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(-0.0F); }

Result<void> checkVertices(const TriMesh& mesh) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    interruptionPoint();
    for (int axis = 0; axis < 3; ++axis) {
      const float x = mesh.vertices[i][axis];
      if (!std::isfinite(x)) return refused(item("vertices", i), "is not finite; every coordinate must be a number");
      if (isNegativeZero(x)) return refused(item("vertices", i), "holds -0; canonical form is +0");
    }
  }
  return {};
}

}  // namespace

bool hasArea(Vec3f a, Vec3f b, Vec3f c) noexcept { return glm::cross(Vec3(b) - Vec3(a), Vec3(c) - Vec3(a)) != Vec3(0); }

Result<void> checkMesh(const TriMesh& mesh) {
  const std::size_t count = mesh.vertices.size();
  if (mesh.triangles.empty()) return refused("triangles", "there are none; a mesh has at least one");
  if (mesh.triangles.size() > kMaxTriangles || count > kMaxVertices) {
    return refused("triangles", "too many; at most " + std::to_string(kMaxTriangles) + " triangles and " +
                                    std::to_string(kMaxVertices) + " vertices are taken");
  }
  if (auto ok = checkVertices(mesh); !ok) return ok;

  std::vector<bool> used(count, false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    interruptionPoint();
    const auto [a, b, c] = mesh.triangles[t];
    for (const std::uint32_t v : {a, b, c}) {
      if (v >= count) {
        return refused(item("triangles", t),
                       "names vertex " + std::to_string(v) + " of " + std::to_string(count) + "; count from 0");
      }
      used[v] = true;
    }
    if (a == b || b == c || c == a) return refused(item("triangles", t), "names a vertex twice");
    if (!hasArea(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c])) {
      return refused(item("triangles", t), "has no area");
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    if (!used[v]) return refused(item("vertices", v), "is not used by any triangle");
  }
  return {};
}

}  // namespace haptics
