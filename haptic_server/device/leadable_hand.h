#pragma once

#include "common/mailbox/triple_buffer.h"
#include "common/telemetry/hand_command.h"
#include "haptic_server/device/exploring_hand.h"

namespace haptics {

/// A hand that goes where a client commands, and explores while none does. Commands come some 60 times a second, early,
/// late or not at all; position and speed of the hand stay continuous whatever comes:
///   - between two commands it moves in the time that has passed between the last ones, so one interval behind;
///   - a command older than kHeld_s is not followed further: the hand stands still and presses as it does;
///   - one older than kReleased_s, or the word that nobody leads, lets it go: it retreats from what it presses, as slowly as
///     it came, lifts and explores.
/// It lets go of what the exploring hand presses before it follows the first command, and lands and lifts slowly. What it feels
/// within kReleased_s after a retreat it takes for a guide or a field, of which no retreat lets go.
/// Where a command presses, the hand goes against the normal until the motors push back with that force. It turns to how the
/// command has it, or the exploring hand, with at most kMaxTurn_rad_per_s. It presses the buttons of the command that it follows,
/// and opens and closes the gripper with at most kMaxTurn_rad_per_s.
class LeadableHand final : public HandIntent {
 public:
  static constexpr double kHeld_s = 0.1, kReleased_s = 0.5;
  static constexpr double kMaxSpeed_m_per_s = 0.6, kMaxAcceleration_m_per_s2 = 30;  ///< Of a hand that is led.

  static constexpr double kMaxTurn_rad_per_s = 2;

  /// @param maxForce_N  Of the device that it holds: it presses with less.
  /// @param startsAt  As for ExploringHand.
  LeadableHand(const HandPreset& hand, double maxForce_N, double startsAt = 0) noexcept;

  /// For one other thread: the newest command wins. Wait-free.
  void command(const HandCommand& command) noexcept { commands_.put(command); }

  [[nodiscard]] HandTarget next(double dt_s, Vec3 felt_N) noexcept override;
  [[nodiscard]] Quat nextRotation(double dt_s) noexcept override;
  [[nodiscard]] double nextGripper_rad(double dt_s, double now_rad) noexcept override;
  [[nodiscard]] std::uint32_t buttons() const noexcept override { return phase_ == Phase::kLed ? command_.buttons : 0; }
  void follow(const ExplorationPlan* plan) noexcept override { exploring_.follow(plan); }

 private:
  void take(const HandCommand& command) noexcept;
  void release() noexcept;
  void beginRetreat() noexcept;
  void retreat(double dt_s) noexcept;
  [[nodiscard]] HandTarget explore(double dt_s, Vec3 felt_N) noexcept;
  void press(double dt_s) noexcept;
  [[nodiscard]] Vec3 commanded() const noexcept;

  ExploringHand exploring_;
  TripleBuffer<HandCommand> commands_;
  const double maxPress_N_;
  const double depthPerForce_;  ///< m/s of depth for a newton of error.

  enum class Phase { kExploring, kLed, kRetreating } phase_ = Phase::kExploring;
  HandCommand command_;   // the newest
  Vec3 from_{0};          // where the way to it began
  double interval_s_;     // smoothed, between commands
  double age_s_ = 0;      // of the newest
  double depth_m_ = 0;    // of the hand below the commanded position
  double pressed_N_ = 0;  // smoothed
  double retreat_m_ = 0;  // so far, from from_
  double sinceRetreat_s_ = kReleased_s;
  Vec3 position_{0}, velocity_{0};
  Quat rotation_{1, 0, 0, 0};
  Vec3 offset_{0}, offsetVelocity_{0};  // from where the exploring hand is, after it was let go
};

}  // namespace haptics
