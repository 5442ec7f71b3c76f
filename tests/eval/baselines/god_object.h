#pragma once

#include <array>

#include "tests/eval/baselines/body_set.h"

namespace haptics::eval {

/// Zilles and Salisbury, A constraint-based god-object method for haptic display, 1995: the god-object moves straight
/// towards the HIP; each polygon in its way becomes an active constraint, and the goal becomes the point nearest to the
/// HIP on up to three of their planes, by Lagrange multipliers. Deviations, in its favour: it moves until it settles,
/// not once a tick, and planes are lifted by a skin of 2^-20 of the extent, so that it never lies below what it touches.
class GodObject : public Baseline {
 public:
  using Baseline::Baseline;
  void place(Vec3 hip) override { god_ = hip; }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 private:
  static constexpr int kMaxActive = 3;
  static constexpr int kMaxMoves = 16;
  struct Plane {
    Vec3 normal;  ///< Unit.
    double offset_m;
  };
  void move(Vec3 hip);
  [[nodiscard]] Plane planeOf(const BodySet::Hit& hit) const;
  [[nodiscard]] Vec3 goal(Vec3 hip) const;

  Vec3 god_{0};
  std::array<Plane, kMaxActive> active_{};
  int activeCount_ = 0;
};

/// The same over the usual test of a ray and a triangle.
class GodObjectByRays final : public GodObject {
 public:
  GodObjectByRays() : GodObject(SegmentTest::kMoellerTrumbore) {}
};

}  // namespace haptics::eval
