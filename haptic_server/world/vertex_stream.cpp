#include "haptic_server/world/vertex_stream.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "haptic_server/world/input_checks.h"

namespace haptics {
namespace {

constexpr float kFarthestVertex_m = 1e3F;
constexpr std::uint32_t kNoSource = std::numeric_limits<std::uint32_t>::max();

[[nodiscard]] bool isPlace(const std::array<float, 3>& v) noexcept {
  return std::ranges::all_of(v, [](float x) { return std::abs(x) <= kFarthestVertex_m; });  // not for NaN
}

}  // namespace

/// Canonical triangles are those of the mesh in their order, without what was left out.
VertexStream::VertexStream(const World::Mesh& mesh, TriMesh canonical)
    : given_(mesh.vertices.size()), rest_(std::move(canonical.vertices)), source_(rest_.size(), kNoSource) {
  std::size_t kept = 0;
  for (const auto& corners : mesh.triangles) {
    if (kept == canonical.triangles.size()) break;
    const TriangleIndices& at = canonical.triangles[kept];
    bool isKept = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& v = mesh.vertices[corners[k]];
      isKept = isKept && Vec3f(v[0], v[1], v[2]) == rest_[at[k]];
    }
    if (!isKept) continue;
    for (std::size_t k = 0; k < 3; ++k) source_[at[k]] = std::min(source_[at[k]], corners[k]);
    ++kept;
  }
}

void VertexStream::take(std::span<const std::array<float, 3>> vertices, const CollisionMesh& surface) {
  if (vertices.size() != given_) {
    refuse("vertices",
           "are " + std::to_string(vertices.size()) + "; the mesh that add() got has " + std::to_string(given_));
  }
  const auto bad = std::ranges::find_if_not(vertices, isPlace);
  if (bad != vertices.end()) {
    refuse("vertices[" + std::to_string(bad - vertices.begin()) + "]",
           "is not finite and within " + text(kFarthestVertex_m) + " m of the body's origin");
  }
  std::shared_ptr<ShapeMemory>& memory = shape_.memory.front();
  if (!memory) {
    for (auto& sample : samples_) sample = std::make_shared<std::vector<Vec3f>>(rest_);
    memory = std::make_shared<ShapeMemory>(surface, rest_.size());
  }
  std::rotate(samples_.begin(), samples_.begin() + 1, samples_.end());
  const std::vector<Vec3f>& last = *samples_[1];
  std::vector<Vec3f>& newest = *samples_[2];
  double way2 = 0;
  for (std::size_t v = 0; v < newest.size(); ++v) {
    const auto& [x, y, z] = vertices[source_[v]];
    newest[v] = {x, y, z};
    way2 = std::max(way2, squaredLength(Vec3(newest[v]) - Vec3(last[v])));
  }
  std::ranges::copy(samples_, shape_.samples.fromOldest.end() - kSamples);
  shape_.way_m = std::sqrt(way2);
  ++shape_.number;
}

}  // namespace haptics
