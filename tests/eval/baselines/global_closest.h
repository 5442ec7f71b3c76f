#pragma once

#include "tests/eval/baselines/body_set.h"

namespace haptics::eval {

/// The penalty method (Massie and Salisbury, The PHANToM haptic interface, 1994): inside a body the force points to its
/// closest surface point. It remembers nothing. Of several bodies the one that the HIP is deepest in.
class GlobalClosest : public Baseline {
 public:
  void place(Vec3 /*hip*/) override {}
  Felt tick(std::span<const Pose> poses, Vec3 hip) override {
    bodies_.setPoses(poses);
    const BodySet::Nearest nearest = bodies_.nearest(hip);
    if (!nearest.inside) return {false, hip, Vec3(0), nearest.triangles};
    return {true, nearest.point, spring_N_per_m() * (nearest.point - hip), nearest.triangles};
  }
};

}  // namespace haptics::eval
