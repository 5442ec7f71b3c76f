#include "haptic_server/device/exploring_hand.h"

#include <algorithm>
#include <numbers>

#include "common/maths/elementary.h"
#include "common/maths/rotation.h"
#include "haptic_server/device/press_control.h"

namespace haptics {
namespace {

constexpr double kPressForce = 2;  // newtons with which the hand wants to press: a light, deliberate touch
/// A device that cannot give that force with kForceReserve is pressed with this share of what it can.
constexpr double kShareOfWeakDevice = 0.6;
constexpr double kNoticedForce = 0.15;  // newtons from which on the hand notices that it touches something
/// Share of the wanted force at which it starts to stroke, and the seconds after which it does so anyway (soft
/// objects).
constexpr double kPressedShare = 0.9;
constexpr double kLongestPress = 1.5;
constexpr double kApproachHeight = 0.015;  // metres above the surface from which it approaches slowly
/// m/s: mean speed of strokes and of movements in the air.
constexpr double kStrokeSpeed = 0.08;
constexpr double kTravelSpeed = 0.25;
/// Seconds: the shortest movement, however near; how long it rubs an object before it finishes the pass and lifts.
constexpr double kShortestReach = 0.2;
constexpr double kRubbingTime = 3;
/// m/s; of the wanted force, at which a push gives up: what it pushes stands fast.
constexpr double kPushSpeed = 0.06;
constexpr double kMaxPush = 1.3;
/// Of the sway: rad, and Hz about x and y, whose quotient makes it go over all inclinations.
constexpr double kSway_rad = 0.25;
constexpr double kSwayAboutX_Hz = 0.13, kSwayAboutY_Hz = 0.21;
constexpr Vec3 kRestingPlace{0, 0, 0.2};  // where it waits when nothing was ever there to explore; metres, world frame

double pressForce(const HandPreset& hand, double maxForce_N) noexcept {
  const double wanted = std::min(kPressForce, kMaxYield_m * hand.stiffness_N_per_m);
  return maxForce_N >= kForceReserve * wanted ? wanted : kShareOfWeakDevice * maxForce_N;
}

Vec3 atHeight(Vec3 point, double z) noexcept { return {point.x, point.y, z}; }

}  // namespace

double Reach::fraction() const noexcept {
  const double s = std::min(elapsed_s / duration_s, 1.0);
  return s * s * s * (10 + s * (6 * s - 15));
}

ExploringHand::ExploringHand(const HandPreset& hand, double maxForce_N, double startsAt) noexcept
    : startsAt_(startsAt),
      targetForce_(pressForce(hand, maxForce_N)),
      forceGain_(hand.stiffness_N_per_m > 0 ? kForceCorrection_per_s / hand.stiffness_N_per_m : 0),
      clearHeight_(kRestingPlace.z),
      position_(kRestingPlace) {}

void ExploringHand::follow(const ExplorationPlan* plan) noexcept {
  plan_ = plan != nullptr && !plan->strokes.empty() ? plan : nullptr;
  if (plan_ == nullptr) {
    pointCount_ = 0;
    if (phase_ != Phase::kNotStarted && phase_ != Phase::kResting) lift();
    return;
  }
  const bool otherHeight = plan_->clearHeight_m != clearHeight_;
  clearHeight_ = plan_->clearHeight_m;

  if (phase_ == Phase::kNotStarted) {
    choose(static_cast<std::size_t>(startsAt_ * static_cast<double>(plan_->strokes.size())));
    position_ = atHeight(points_[0], clearHeight_);
    return;
  }
  const auto& strokes = plan_->strokes;
  const auto same =
      std::ranges::find_if(strokes, [this](const Stroke& s) { return s.object == object_ && s.isPush == isPush_; });
  if (same != strokes.end() && std::ranges::equal(points(), same->points)) {
    stroke_ = static_cast<std::size_t>(same - strokes.begin());
    if (otherHeight && (phase_ == Phase::kLifting || phase_ == Phase::kCrossing)) lift();
    return;
  }
  const auto after = std::ranges::find_if(strokes, [this](const Stroke& s) { return s.object > object_; });
  const auto chosen = same != strokes.end() ? same : after != strokes.end() ? after : strokes.begin();
  choose(static_cast<std::size_t>(chosen - strokes.begin()));
  lift();
}

HandTarget ExploringHand::next(double dt_s, Vec3 felt_N) noexcept {
  felt_ += (glm::length(felt_N) - felt_) * (dt_s / (kFeltSmoothing_s + dt_s));
  switch (phase_) {
    case Phase::kNotStarted:
      phase_ = Phase::kResting;
      if (plan_ != nullptr) descend();
      break;
    case Phase::kResting:
      break;
    case Phase::kLifting:
    case Phase::kCrossing:
    case Phase::kDescending:
    case Phase::kRetreating:
      move(dt_s);
      break;
    case Phase::kApproaching:
      approach(dt_s);
      break;
    case Phase::kRubbing:
      rub(dt_s);
      break;
    case Phase::kPushing:
      push(dt_s);
      break;
  }
  return {position_, Vec3(0)};
}

Quat ExploringHand::nextRotation(double dt_s) noexcept {
  constexpr double kTurn = 2 * std::numbers::pi;
  swayed_ += dt_s;
  return rotationBy(kSway_rad * Vec3(elementary::sin(kTurn * kSwayAboutX_Hz * swayed_),
                                     elementary::sin(kTurn * kSwayAboutY_Hz * swayed_), 0));
}

void ExploringHand::resumeAt(Vec3 position) noexcept {
  position_ = position;
  lift();
}

/// The stroke to make for; a copy, because the plan may be replaced on the way.
void ExploringHand::choose(std::size_t stroke) noexcept {
  const Stroke& chosen = plan_->strokes[stroke];
  stroke_ = stroke;
  object_ = chosen.object;
  isPush_ = chosen.isPush;
  pointCount_ = std::min(chosen.points.size(), kMaxStrokePoints);
  std::copy_n(chosen.points.begin(), pointCount_, points_.begin());
  length_ = 0;
  for (std::size_t i = 1; i < pointCount_; ++i) length_ += glm::distance(points_[i - 1], points_[i]);
}

void ExploringHand::lift() noexcept { reach(Phase::kLifting, atHeight(position_, clearHeight_)); }

/// To above the stroke, or to where a push begins.
void ExploringHand::descend() noexcept {
  reach(Phase::kDescending, isPush_ ? points_[0] : points_[0] + Vec3(0, 0, kApproachHeight));
}

void ExploringHand::goOn() noexcept {
  choose((stroke_ + 1) % plan_->strokes.size());
  lift();
}

void ExploringHand::reach(Phase phase, Vec3 to) noexcept {
  phase_ = phase;
  reach_ = {position_, to, std::max(glm::distance(position_, to) / kTravelSpeed, kShortestReach), 0};
}

void ExploringHand::move(double dt_s) noexcept {
  reach_.elapsed_s += dt_s;
  position_ = reach_.position();
  if (!reach_.done()) return;
  if (pointCount_ == 0) {
    phase_ = Phase::kResting;
  } else if (phase_ == Phase::kLifting) {
    reach(Phase::kCrossing, atHeight(points_[0], position_.z));
  } else if (phase_ == Phase::kCrossing) {
    descend();
  } else if (phase_ == Phase::kRetreating) {
    goOn();
  } else if (isPush_) {
    phase_ = Phase::kPushing;
    reach_ = {{}, {}, std::max(length_ / kPushSpeed, kShortestReach), 0};
  } else {
    phase_ = Phase::kApproaching;
    depth_ = points_[0].z - position_.z;
  }
}

void ExploringHand::approach(double dt_s) noexcept {
  depth_ = std::min(depth_ + kPressSpeed_m_per_s * dt_s, kMaxPressDepth_m);
  position_ = points_[0] - Vec3(0, 0, depth_);
  if (felt_ > kNoticedForce) {
    phase_ = Phase::kRubbing;
    reach_ = {};
    pressed_ = rubbed_ = 0;
    stroking_ = backwards_ = false;
  } else if (depth_ >= kMaxPressDepth_m) {
    goOn();
  }
}

void ExploringHand::rub(double dt_s) noexcept {
  depth_ += std::clamp(forceGain_ * (targetForce_ - felt_), -kTravelSpeed, kPressSpeed_m_per_s) * dt_s;
  depth_ = std::min(depth_, kMaxPressDepth_m);
  const bool lost = depth_ >= kMaxPressDepth_m && felt_ < kNoticedForce;
  const bool pushedAway = depth_ < -kApproachHeight;
  if (lost || pushedAway) return goOn();

  if (stroking_) {
    rubbed_ += dt_s;
    reach_.elapsed_s += dt_s;
    if (reach_.done()) {
      if (rubbed_ >= kRubbingTime) return goOn();
      backwards_ = !backwards_;
      startPass();
    }
  } else {
    pressed_ += dt_s;
    if (felt_ >= kPressedShare * targetForce_ || pressed_ >= kLongestPress) startPass();
  }
  const double fraction = reach_.fraction();
  position_ = pointAt(backwards_ ? 1 - fraction : fraction) - Vec3(0, 0, depth_);
}

void ExploringHand::push(double dt_s) noexcept {
  reach_.elapsed_s += dt_s;
  position_ = pointAt(reach_.fraction());
  if (reach_.done() || felt_ > kMaxPush * targetForce_) reach(Phase::kRetreating, points_[0]);
}

void ExploringHand::startPass() noexcept {
  stroking_ = true;
  reach_ = {{}, {}, std::max(length_ / kStrokeSpeed, kShortestReach), 0};
}

Vec3 ExploringHand::pointAt(double fraction) const noexcept {
  const double place = fraction * static_cast<double>(pointCount_ - 1);
  const auto before = static_cast<std::size_t>(place);
  const std::size_t after = std::min(before + 1, pointCount_ - 1);
  return glm::mix(points_[before], points_[after], place - static_cast<double>(before));
}

}  // namespace haptics
