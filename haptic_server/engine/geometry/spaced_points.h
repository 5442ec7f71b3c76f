#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Places no two of which are nearer than a spacing (m).
class SpacedPoints {
 public:
  explicit SpacedPoints(double spacing_m) : spacing_(spacing_m) {}

  /// Unless another one is nearer than the spacing. False: one is.
  bool add(Vec3 place);
  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }
  /// In the order in which they were added.
  [[nodiscard]] std::vector<Vec3> take() noexcept { return std::move(points_); }

 private:
  using Cell = std::array<std::int64_t, 3>;
  double spacing_;
  std::vector<Vec3> points_;
  std::unordered_multimap<std::uint64_t, std::size_t> cells_;

  [[nodiscard]] bool hasRoomAt(Vec3 place) const;
  [[nodiscard]] Cell cellOf(Vec3 place) const;
};

/// Lines whose faces' normals differ by more (30 degrees) are sharp, and those at which no two triangles meet.
inline constexpr double kSharp_rad = 0.5235987755982988;

/// Adds the ends of a mesh's sharp lines first, then places along them. Object frame, metres. False: there are more than
/// `max` then, and some are missing.
[[nodiscard]] bool addSharpPoints(const CollisionMesh& mesh, double spacing_m, std::size_t max, SpacedPoints& points);

/// Those alone. Where there are more than `max` the spacing is doubled until there are not.
[[nodiscard]] std::vector<Vec3> sharpPoints(const CollisionMesh& mesh, double spacing_m, std::size_t max);

}  // namespace haptics
