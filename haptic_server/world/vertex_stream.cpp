#include "haptic_server/world/vertex_stream.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "haptic_server/world/input_checks.h"

namespace haptics {
namespace {

constexpr float kFarthestVertex_m = 1e3F;

[[nodiscard]] bool isPlace(const std::array<float, 3>& v) noexcept {
  return std::ranges::all_of(v, [](float x) { return std::abs(x) <= kFarthestVertex_m; });  // not for NaN
}

}  // namespace

VertexStream::VertexStream(std::size_t given, ImportedMesh canonical)
    : given_(given), rest_(std::move(canonical.mesh.vertices)), source_(std::move(canonical.source)) {}

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
