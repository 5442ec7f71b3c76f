#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Vertices of a shape, in the mesh's canonical numbering; object frame, metres.
using ShapeSample = std::shared_ptr<const std::vector<Vec3f>>;

/// The newest samples of whoever moves an object's vertices: its shape goes from one to the next evenly.
struct ShapeSamples {
  /// One more than a stream without gaps needs, in which a sample comes before the last is reached: for some that come at once.
  static constexpr std::size_t kMax = 4;
  static constexpr double kNewest = kMax - 1;  ///< "Along" them (ShapeMemory::moveTo()).

  std::array<ShapeSample, kMax> fromOldest;  ///< At least the last two; null before the first.

  [[nodiscard]] double oldest() const noexcept {
    return static_cast<double>(std::ranges::find_if(fromOldest, [](const auto& s) { return s != nullptr; }) -
                               fromOldest.begin());
  }

  [[nodiscard]] bool operator==(const ShapeSamples&) const = default;
};

/// Room for the surface of an object whose vertices move, in this tick and the last: prepared off the servo thread, filled by the
/// tick of one hand without allocating. What is in it follows from the samples: it is a cache.
class ShapeMemory {
 public:
  /// @param surface  Before the first sample; of so many vertices.
  ShapeMemory(const CollisionMesh& surface, std::size_t vertices);

  struct Moved {
    const CollisionMesh* surface = nullptr;  ///< Valid until the second call from here.
    double farthest_m = 0;                   ///< Way of the vertex that goes farthest.
  };
  /// The surface as it is `along` the samples, by their index: from oldest() to kNewest.
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
