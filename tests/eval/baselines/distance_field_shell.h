#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/tool/tool_contact.h"

namespace haptics::eval {

/// Signed distances of a closed mesh on a grid of cubic cells about it, negative inside, trilinear between (Barbic & James,
/// Six-DoF Haptic Rendering of Contact between Geometrically Complex Reduced Deformable Models, 2008). Mesh frame, metres.
class DistanceField {
 public:
  struct Sample {
    double distance_m;
    Vec3 gradient;
  };

  /// @param cells  Along the longest side of the mesh and of the margin about it.
  DistanceField(const CollisionMesh& surface, int cells, double margin_m);

  /// None: outside of the grid.
  [[nodiscard]] std::optional<Sample> at(Vec3 place) const noexcept;
  /// From a place outside of the grid to it, at least.
  [[nodiscard]] double distanceToGrid(Vec3 place) const noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept { return value_.size() * sizeof(float); }
  [[nodiscard]] double cell_m() const noexcept { return cell_; }

 private:
  Vec3 low_{0}, high_{0};
  double cell_ = 0;
  std::size_t nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<float> value_;  // x fastest

  [[nodiscard]] const float* corner(std::size_t x, std::size_t y, std::size_t z) const noexcept {
    return &value_[(z * ny_ + y) * nx_ + x];
  }
};

/// A tool whose points are pushed out of such a field by springs and hang on the device by the coupling: the point shell of
/// McNeely, Puterbaugh & Troy (1999) in a distance field, at static equilibrium by one Newton step a tick (Barbic & James
/// 2008, static virtual coupling). A point that is known to be far away is not looked up until the tool has moved as far.
/// **Deviation**: no tree of points that is left off where time is short.
class DistanceFieldShell {
 public:
  static constexpr double kPoint_N_per_m = 2000;  ///< Spring of each point.

  DistanceFieldShell(const ToolShell& shell, const DistanceField& field, const ToolCoupling& coupling)
      : shell_(shell), field_(field), coupling_(coupling), clearTo_(shell.points.size(), -1) {}

  void reset(const Pose& device) { pose_ = device; }
  /// @return Where the tool is, in the frame of the field.
  const Pose& follow(const Pose& device) noexcept;
  [[nodiscard]] int touching() const noexcept { return touching_; }  ///< Points inside, in the last tick.

 private:
  const ToolShell& shell_;
  const DistanceField& field_;
  ToolCoupling coupling_;
  Pose pose_;
  double travelled_ = 0;         // m, at most, of any point
  std::vector<double> clearTo_;  // travelled_ until which a point is in nothing
  int touching_ = 0;
};

}  // namespace haptics::eval
