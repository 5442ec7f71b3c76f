#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/device/hand_intent.h"
#include "haptic_server/device/presets.h"

namespace haptics {

/// A point-to-point movement of least jerk (Flash & Hogan 1985): 10 s^3 - 15 s^4 + 6 s^5 of the way, s = time /
/// duration.
struct Reach {
  Vec3 from{0}, to{0};
  double duration_s = 1;
  double elapsed_s = 0;

  [[nodiscard]] bool done() const noexcept { return elapsed_s >= duration_s; }
  [[nodiscard]] double fraction() const noexcept;  ///< Of the way, 0 to 1.
  [[nodiscard]] Vec3 position() const noexcept { return glm::mix(from, to, fraction()); }
};

/// A hand that explores the objects of a plan, for ever: over the start of a stroke at a clear height, down until it
/// feels the surface, press to about 2 N (less with a loose hand or a weak device), rub there and back along the stroke
/// while it keeps that force, lift, next. A push goes along its points, until it meets more force than it wants to give. It feels only the force that the device gives it. When a surface is not where
/// the plan has it, it lifts and goes on. A device that turns it sways slowly about both horizontal axes.
class ExploringHand final : public HandIntent {
 public:
  /// @param maxForce_N  Of the device that it holds.
  /// @param startsAt  The share of a plan's strokes that it passes over at first, below 1: two hands do not begin together.
  ExploringHand(const HandPreset& hand, double maxForce_N, double startsAt = 0) noexcept;

  [[nodiscard]] HandTarget next(double dt_s, Vec3 felt_N) noexcept override;
  [[nodiscard]] Quat nextRotation(double dt_s) noexcept override;
  /// A stroke that the new plan holds unchanged goes on; from another one the hand lifts.
  void follow(const ExplorationPlan* plan) noexcept override;
  /// Something else has brought the hand here: it lifts, and goes on with its stroke.
  void resumeAt(Vec3 position) noexcept;

  [[nodiscard]] double targetForce_N() const noexcept { return targetForce_; }

 private:
  enum class Phase : std::uint8_t {
    kNotStarted,
    kResting,
    kLifting,
    kCrossing,
    kDescending,
    kApproaching,
    kRubbing,
    kPushing,
    kRetreating
  };

  void choose(std::size_t stroke) noexcept;
  void lift() noexcept;
  void descend() noexcept;
  void goOn() noexcept;
  void reach(Phase phase, Vec3 to) noexcept;
  void move(double dt_s) noexcept;
  void approach(double dt_s) noexcept;
  void rub(double dt_s) noexcept;
  void push(double dt_s) noexcept;
  void startPass() noexcept;
  [[nodiscard]] Vec3 pointAt(double fraction) const noexcept;
  [[nodiscard]] std::span<const Vec3> points() const noexcept { return {points_.data(), pointCount_}; }

  double startsAt_;
  double targetForce_;  // N
  double forceGain_;    // m/s of depth per newton of error

  const ExplorationPlan* plan_ = nullptr;
  std::size_t stroke_ = 0;  // index into the plan of the one copied here
  std::uint64_t object_ = 0;
  bool isPush_ = false;
  std::array<Vec3, kMaxStrokePoints> points_{};
  std::size_t pointCount_ = 0;
  double length_ = 0;   // m
  double clearHeight_;  // m, of the plan

  Phase phase_ = Phase::kNotStarted;
  Vec3 position_{0};
  Reach reach_;
  double felt_ = 0;     // N, magnitude, smoothed
  double depth_ = 0;    // m, of the intended position below the stroke; negative above it
  double pressed_ = 0;  // s since the surface was met
  double rubbed_ = 0;   // s of stroking in this visit
  double swayed_ = 0;   // s
  bool stroking_ = false;
  bool backwards_ = false;
};

}  // namespace haptics
