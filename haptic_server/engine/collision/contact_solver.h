#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "haptic_server/engine/collision/body_pairs.h"

namespace haptics {

/// A body while impulses act on it: where it is does not change meanwhile. World frame.
class Mover {
 public:
  /// It stands still, whatever acts on it.
  Mover() = default;
  Mover(const RigidBody& body, RigidState& state, double period_s) noexcept;
  /// It moves so, whatever acts on it.
  Mover(Vec3 pivot, const RigidVelocity& velocity) noexcept
      : centre_(pivot), linear_(velocity.linear), angular_(velocity.angular) {}

  [[nodiscard]] Vec3 velocityAt(Vec3 place) const noexcept;
  [[nodiscard]] Vec3 angularVelocity() const noexcept { return freedom_ == Freedom::kHinge ? rate_ * axis_ : angular_; }
  /// Times an impulse at the place: what it adds to the velocity there, limits of a joint apart; 1 / kg.
  [[nodiscard]] glm::dmat3 mobility(Vec3 place) const noexcept;
  [[nodiscard]] glm::dmat3 perInertia() const noexcept { return perInertia_; }
  void push(Vec3 place, Vec3 impulse_Ns) noexcept;
  void turn(Vec3 impulse_Nms) noexcept;
  /// Gives the body all impulses since the last call.
  void give() noexcept;

 private:
  RigidState* state_ = nullptr;
  Freedom freedom_ = Freedom::kFree;
  Vec3 centre_{0}, linear_{0}, angular_{0};
  double perMass_ = 0;
  glm::dmat3 perInertia_{0};
  Vec3 impulse_Ns_{0}, impulse_Nms_{0};  // not given yet
  // On a joint.
  Vec3 axis_{0}, anchor_{0};
  double perAlong_ = 0, rate_ = 0, lowest_ = 0, highest_ = 0;

  [[nodiscard]] Vec3 direction(Vec3 place) const noexcept {
    return freedom_ == Freedom::kSlider ? axis_ : glm::cross(axis_, place - anchor_);
  }
};

/// One point at which a body is pushed away from another. Arrays of them are filled as far as they are used.
struct ContactConstraint {
  std::uint16_t a, b;  ///< Movers: pushed along the normal, and against it.
  Vec3 place;          ///< World, m.
  Vec3 normal;         ///< Unit.
  Vec3 along[2];       ///< Two directions across it.
  double gap_m;
  double friction;
  double rolling_m;
  double mass_kg[3];      ///< Effective, along the three.
  double across_1_kg[2];  ///< What a pressing impulse of 1 Ns adds to the velocities across.
  double pressing_Ns;
  double rubbing_Ns[2];

  [[nodiscard]] Vec3 impulse() const noexcept {
    return pressing_Ns * normal + rubbing_Ns[0] * along[0] + rubbing_Ns[1] * along[1];
  }
};

/// Resistance of two bodies' contacts to rolling and spinning on each other.
struct RollingConstraint {
  std::uint16_t a, b;
  std::uint32_t begin, end;  ///< Of the contacts that press.
  glm::dmat3 inertia;        ///< Effective.
  Vec3 turning_Nms;
};

/// The spring that pushes overlapping bodies apart.
struct ContactSpring {
  double rate_per_s, massScale, impulseScale;
};

/// Constraints of a tick, solved in turn.
class ContactSolver {
 public:
  static constexpr std::size_t kMaxContacts = 768;
  static constexpr std::size_t kMaxRolling = kMaxPairs + kMaxMovingBodies;

  ContactSolver(std::span<Mover> movers, double period_s) noexcept;

  /// A contact with the impulse that it had in the last tick. False: there is no room.
  [[nodiscard]] bool add(std::uint16_t a, std::uint16_t b, Vec3 place, Vec3 normal, double gap_m, double friction,
                         double rolling_m, Vec3 lastImpulse_Ns) noexcept;
  /// Of the contacts from `begin` on.
  void addRolling(std::uint32_t begin, Vec3 lastTurning_Nms) noexcept;
  /// The movers get the impulses of the last tick.
  void warmStart() noexcept;
  /// @param soft  Overlap is pushed apart.
  /// @return How much the impulses changed, of what presses.
  double solve(bool soft) noexcept;
  /// The bodies have moved by a tick at the speeds that they have.
  void moved() noexcept;

  [[nodiscard]] std::uint32_t size() const noexcept { return count_; }
  [[nodiscard]] std::uint32_t rollingSize() const noexcept { return rollingCount_; }
  [[nodiscard]] const ContactConstraint& contact(std::uint32_t i) const noexcept { return contacts_[i]; }
  [[nodiscard]] const RollingConstraint& rolling(std::uint32_t i) const noexcept { return rolling_[i]; }

 private:
  std::span<Mover> movers_;
  double period_s_;
  ContactSpring spring_;
  std::array<ContactConstraint, kMaxContacts> contacts_;
  std::array<RollingConstraint, kMaxRolling> rolling_;
  std::uint32_t count_ = 0, rollingCount_ = 0;

  [[nodiscard]] Vec3 velocity(const ContactConstraint& c) const noexcept {
    return movers_[c.a].velocityAt(c.place) - movers_[c.b].velocityAt(c.place);
  }
  void push(const ContactConstraint& c, Vec3 impulse_Ns) noexcept {
    movers_[c.a].push(c.place, impulse_Ns);
    movers_[c.b].push(c.place, -impulse_Ns);
  }
  double solve(ContactConstraint& c, bool soft) noexcept;
  void solve(RollingConstraint& r) noexcept;
};

}  // namespace haptics
