#include "haptic_server/engine/surface/friction.h"

namespace haptics {

Vec3 StickSlip::follow(const PressedPoint& at, FrictionCoefficients mu, const FrictionScale& scale,
                       double period_s) noexcept {
  if (state_ != FrictionState::kSticking && !(mu.stick > 0)) {
    release();
    return Vec3(0);
  }
  if (state_ == FrictionState::kNone) {
    state_ = FrictionState::kSticking;
    mu_ = mu;
    point_ = at.place;
  }
  Vec3 stretch = point_ - at.place;
  stretch -= glm::dot(stretch, at.normal) * at.normal;  // the sticking point, projected on the surface again
  const double length = glm::length(stretch);
  const double limit = at.pressing_N / scale.stiffness_N_per_m;

  if (length > limit) {
    state_ = FrictionState::kSliding;
    stretch *= limit / length;
    point_ = at.place + stretch;
    rested_s_ = 0;
    mu_ = mu;
  } else if (state_ == FrictionState::kSliding) {
    rested_s_ += period_s;
    mu_ = mu;
    if (length < limit - scale.hysteresis_m || rested_s_ > kRest_s) {
      state_ = FrictionState::kSticking;
      stretch *= mu.stick > 0 ? mu.slide / mu.stick : 1;
      point_ = at.place + stretch;
    }
  }
  return scale.stiffness_N_per_m * (state_ == FrictionState::kSticking ? mu_.stick : mu_.slide) * stretch;
}

}  // namespace haptics
