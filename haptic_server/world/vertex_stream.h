#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/mesh/import.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/world/world.h"

namespace haptics {

/// The samples of where a body's vertices are, as its user numbers them.
class VertexStream {
 public:
  /// @param given  Vertices of the mesh that this was made of.
  VertexStream(std::size_t given, ImportedMesh canonical);

  /// Allocates at its first call.
  /// @throws InvalidInput another number of vertices, a place that cannot be; nothing is taken then.
  void take(std::span<const std::array<float, 3>> vertices, const CollisionMesh& surface);
  [[nodiscard]] const KinematicShape& shape() const noexcept { return shape_; }  ///< Of the newest sample.

 private:
  std::size_t given_;  // vertices
  std::vector<Vec3f> rest_;
  std::vector<std::uint32_t> source_;  // of each canonical vertex, the one that was given
  static constexpr std::size_t kSamples = 3;
  std::array<std::shared_ptr<std::vector<Vec3f>>, kSamples> samples_;  // the oldest first
  KinematicShape shape_;
};

}  // namespace haptics
