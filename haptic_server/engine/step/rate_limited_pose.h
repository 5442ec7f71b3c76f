#pragma once

#include <algorithm>

#include "haptic_server/engine/force/spring_damper.h"

namespace haptics {

/// Bounds how fast an edit of the pose is felt: an object under the stylus goes to its new place as a moving body does,
/// with the IHIP on it, instead of passing through the stylus at once.
class RateLimitedPose {
 public:
  /// Seconds that such a motion may take. One that would take longer is not made: the contact is let go, and the object
  /// is then at its new place at once. Larger keeps the contact over longer edits, and the viewer's picture wrong.
  static constexpr double kLongest_s = 0.25;
  /// Newtons that the motion may add to the damper's force. With RateLimitedStiffness::kRate_N_per_s it bounds the
  /// speed: 30 mm/s at 1000 N/m and up to 0.67 Ns/m.
  static constexpr double kDamping_N = 0.02;

  /// @param hip, ihip  World, metres: the force depends on where these two are in the object's frame.
  /// @param k  Of the object, as it is felt or comes to be felt on the way, whichever is more.
  RateLimitedPose(Vec3 hip, Vec3 ihip, Stiffness k) noexcept : hip_(hip), ihip_(ihip), k_(k) {}

  /// Is an edit from one pose to another made as a motion?
  [[nodiscard]] bool follows(const Pose& from, const Pose& to) const noexcept {
    return part(from, to, kLongest_s) >= 1;
  }
  /// The pose a tick later.
  [[nodiscard]] Pose next(const Pose& from, const Pose& to, double period_s) const noexcept {
    const double now = part(from, to, period_s);
    return now >= 1 ? to : interpolate(from, to, now);
  }

 private:
  /// The part of the path from one pose to another that may be made in a time.
  [[nodiscard]] double part(const Pose& from, const Pose& to, double time_s) const noexcept {
    const auto carried = [&](Vec3 world) { return glm::distance(toWorld(to, toLocal(from, world)), world); };
    const double way = std::max(carried(hip_), carried(ihip_));
    const double seconds =
        way * std::max(k_.spring_N_per_m / RateLimitedStiffness::kRate_N_per_s, k_.damping_Ns_per_m / kDamping_N);
    return seconds > time_s ? time_s / seconds : 1;
  }

  Vec3 hip_;
  Vec3 ihip_;
  Stiffness k_;
};

}  // namespace haptics
