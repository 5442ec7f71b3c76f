#pragma once

#include "tests/eval/baselines/body_set.h"

namespace haptics::eval {

/// The intermediate representation (Adachi, Kumano and Ogino, Intermediate representation for stiff virtual objects,
/// 1995; Mark et al., Adding force feedback to graphics systems, 1996): a slow process puts a tangent plane at the
/// closest surface point, and the servo feels that plane until the next one. No force is faded in when it changes.
template <int kRate_Hz>
class IntermediatePlane final : public Baseline {
 public:
  void place(Vec3 hip) override {
    tick_ = 0;
    updatePlane(hip);
  }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override {
    constexpr int kTicks = static_cast<int>(1 / (kPeriod_s * kRate_Hz));
    bodies_.setPoses(poses);
    const int looked = ++tick_ % kTicks == 0 ? updatePlane(hip) : 0;
    const double depth = glm::dot(normal_, point_ - hip);
    if (depth <= 0) return {false, hip, Vec3(0), looked};
    return {true, hip + normal_ * depth, normal_ * (spring_N_per_m() * depth), looked};
  }

 private:
  int updatePlane(Vec3 hip) {
    const BodySet::Nearest nearest = bodies_.nearest(hip);
    const Vec3 way = nearest.inside ? nearest.point - hip : hip - nearest.point;
    point_ = nearest.point;
    normal_ = nearest.distance_m > 0 ? way / nearest.distance_m : nearest.normal;
    return nearest.triangles;
  }

  Vec3 point_{0};
  Vec3 normal_{0};
  int tick_ = 0;
};

}  // namespace haptics::eval
