#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Vertices of a shape, in the mesh's canonical numbering; object frame, metres.
using ShapeSample = std::shared_ptr<const std::vector<Vec3f>>;

/// The newest sample of whoever moves an object's vertices, and the two before: its shape goes from one to the next evenly.
struct ShapeSamples {
  std::array<ShapeSample, 3> from_oldest;

  [[nodiscard]] bool operator==(const ShapeSamples&) const = default;
};

/// Room for the surface of an object whose vertices move, in this tick and the last: prepared off the servo thread, filled by the
/// tick of one hand without allocating. What is in it follows from the samples: it is a cache.
class ShapeMemory {
 public:
  /// @param surface, vertices  Before the first sample.
  ShapeMemory(const CollisionMesh& surface, std::span<const Vec3f> vertices);

  struct Moved {
    const CollisionMesh* surface = nullptr;  ///< Valid until the second call from here.
    double farthest_m = 0;                   ///< Way of the vertex that goes farthest.
  };
  /// The surface as it is `along` the samples: 0 is the oldest, 2 the newest.
  /// @param before  The surface from which it comes: one of here, or else what it was made of.
  [[nodiscard]] Moved moveTo(const ShapeSamples& samples, double along, const CollisionMesh* before) noexcept;

 private:
  struct Slot {
    CollisionMesh surface;
    std::vector<Vec3f> vertices;
  };
  std::array<Slot, 2> slots_;
};

}  // namespace haptics
