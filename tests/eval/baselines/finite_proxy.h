#pragma once

#include "tests/eval/baselines/body_set.h"

namespace haptics::eval {

/// Ruspini, Kolarov and Khatib, The haptic display of complex graphical environments, 1997: a sphere of finite radius, a
/// point among configuration space obstacles, moves straight towards its goal until it touches one; every obstacle that
/// it touches there is a local constraint plane, and the next goal is the point nearest to the HIP above these planes.
/// It moves until the distance shrinks no more. Topology and side of the mesh mean nothing to it.
///
/// Deviation, in its favour: the IHIP is the point of the sphere that is nearest to the HIP. As published it is the
/// sphere's centre, and everything is felt a radius before it is there, by 1 N at kSpring_N_per_m.
class FiniteProxy final : public Baseline {
 public:
  static constexpr double kRadius_m = 0.001;

  void place(Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 private:
  static constexpr int kMaxMoves = 32;
  static constexpr double kTouching = 1e-7;  ///< Of the radius: an obstacle not farther away is touched.
  static constexpr std::size_t kMaxPlanes = 16;

  /// Calls visit(triangle) for all triangles of a body that a ball about `centre` (world) may meet.
  template <class Visit>
  void forNear(int body, Vec3 centre, double radius, Visit visit) const;
  /// Normals of the constraint planes, all through the proxy, which is put back to where it just touches.
  [[nodiscard]] std::vector<Vec3> touchedPlanes();
  [[nodiscard]] double firstTouch(Vec3 way) const;

  Vec3 proxy_{0};  // the sphere's centre, world
};

}  // namespace haptics::eval
