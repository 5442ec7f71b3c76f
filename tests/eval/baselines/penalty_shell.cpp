#include "tests/eval/baselines/penalty_shell.h"

#include <algorithm>
#include <cmath>

namespace haptics::eval {
namespace {

constexpr double kStiffness_N_per_m = 2000;  // of each point
constexpr int kRounds = 30;                  // of a tick, towards where springs and coupling balance

[[nodiscard]] Vec3 rotationVector(const Quat& q) {
  const Quat shorter = q.w < 0 ? -q : q;
  const Vec3 axis(shorter.x, shorter.y, shorter.z);
  const double sine = glm::length(axis);
  return sine > 0 ? axis * (2 * std::atan2(sine, shorter.w) / sine) : Vec3(0);
}

}  // namespace

const Pose& PenaltyShell::follow(std::span<const Body> bodies, const Pose& device) {
  pose_ = device;
  for (int round = 0; round < kRounds; ++round) {
    Vec3 force = coupling_.stiffness_N_per_m * (device.position - pose_.position);
    Vec3 torque = coupling_.torsion_Nm_per_rad * rotationVector(device.rotation * glm::conjugate(pose_.rotation));
    double stiffness = coupling_.stiffness_N_per_m, torsion = coupling_.torsion_Nm_per_rad;
    for (const Vec3& point : tool_.shell.points) {
      const Vec3 place = toWorld(pose_, point);
      for (const Body& body : bodies) {
        if (!withinSphere(body, place)) continue;
        const Vec3 at = body.frame.toLocal(place);
        int looked = 0;
        const ClosestPoint foot = body.surface->closestFoot(at, 1 << 20, looked);
        if (body.surface->isOutside(foot, at)) continue;
        const Vec3 push = kStiffness_N_per_m * body.frame.rotate(foot.point - at);
        const Vec3 arm = place - pose_.position;
        force += push;
        torque += glm::cross(arm, push);
        stiffness += kStiffness_N_per_m;
        torsion += kStiffness_N_per_m * glm::dot(arm, arm);
      }
    }
    pose_.position += force / stiffness;
    const Vec3 turn = torque / torsion;
    const double angle = glm::length(turn);
    if (angle > 0) pose_.rotation = glm::normalize(glm::angleAxis(angle, turn / angle) * pose_.rotation);
  }
  return pose_;
}

}  // namespace haptics::eval
