#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "haptic_server/engine/collision/body_pairs.h"

namespace haptics {

/// A tick is divided into steps: a body sinks into what it lies on by the square of a step, times the load upon it.
struct TickSteps {
  int count;
  double step_s;

  [[nodiscard]] double period_s() const noexcept { return count * step_s; }
};

struct Momenta {
  Vec3 momentum_Ns{0}, angularMomentum_Nms{0};
  double rate_per_s = 0;  ///< On a joint.
};

/// A body while impulses act on it, in steps of a tick. Where it is counts as at the tick's start: what it turns by within a tick
/// is of second order. World frame. Arrays of them are filled as far as they are used.
class Mover {
 public:
  /// Mover() stands still, whatever acts on it.
  Mover() = default;
  /// @param before  At the tick's start. What forces have made of it since comes in equal parts with each step.
  Mover(const RigidBody& body, RigidState& state, const Momenta& before, const TickSteps& steps) noexcept;
  /// It moves so, whatever acts on it.
  Mover(Vec3 pivot, const RigidVelocity& velocity) noexcept {
    *this = Mover();
    pivot_ = pivot;
    linear_ = velocity.linear;
    angular_ = velocity.angular;
  }

  /// Of the place pivot(), m/s, and about it, rad/s.
  [[nodiscard]] Vec3 linear() const noexcept { return linear_; }
  [[nodiscard]] Vec3 angular() const noexcept { return angular_; }
  [[nodiscard]] Vec3 pivot() const noexcept { return pivot_; }
  /// What an impulse along a direction adds to linear(), 1 / kg; limits of a joint apart, as in the next.
  [[nodiscard]] Vec3 perImpulse(Vec3 along) const noexcept {
    return freedom_ == Freedom::kSlider ? perAlong_ * glm::dot(axis_, along) * axis_ : perMass_ * along;
  }
  /// What an impulsive torque adds to angular(), 1 / kg m^2.
  [[nodiscard]] const glm::dmat3& perInertia() const noexcept { return perInertia_; }
  /// A step's part of the forces.
  void drive() noexcept;
  /// @param turn_rad_per_s  perInertia() times the impulse's torque about the pivot.
  void push(Vec3 impulse_Ns, Vec3 turn_rad_per_s) noexcept {
    if (freedom_ != Freedom::kFree) return pushOnJoint(impulse_Ns, turn_rad_per_s);
    linear_ += perMass_ * impulse_Ns;
    angular_ += turn_rad_per_s;
  }
  void turn(Vec3 impulse_Nms) noexcept {
    if (state_ == nullptr) return;
    const Vec3 turn_rad_per_s = perInertia_ * impulse_Nms;
    if (freedom_ != Freedom::kFree) return pushOnJoint(Vec3(0), turn_rad_per_s);
    angular_ += turn_rad_per_s;
  }
  /// Rounds begin.
  void beginRounds() noexcept;
  /// After a round: by so much of the direction of search, to which what the round did is added.
  void accelerate(double part) noexcept;
  /// By a step.
  void move() noexcept;
  /// Kinetic; of what stands still, or moves whatever acts on it, 0.
  [[nodiscard]] double energy_J() const noexcept;
  /// Leaves so much of its velocity.
  void slow(double part) noexcept;
  /// The state after the tick's steps.
  void give() noexcept;

 private:
  const RigidBody* body_;
  RigidState* state_;
  Freedom freedom_;
  TickSteps steps_;
  Vec3 pivot_, linear_, angular_;
  Vec3 linearOfStep_, angularOfStep_;        // what forces add
  Vec3 linearBefore_, angularBefore_;        // the round
  Vec3 linearConjugate_, angularConjugate_;  // the direction of search
  Vec3 moved_m_, turned_rad_;
  double perMass_;
  glm::dmat3 perInertia_;
  // On a joint, whose anchor is the pivot.
  Vec3 axis_;
  double perAlong_, rate_, rateOfStep_, coordinate_;

  void pushOnJoint(Vec3 impulse_Ns, Vec3 turn_rad_per_s) noexcept;
  /// Of a joint: no farther than its limits in a step.
  void setRate(double rate_per_s) noexcept;
};

/// One point at which a body is pushed away from another; impulses are those of a step. Arrays of them are filled as far as
/// they are used.
struct ContactConstraint {
  /// Of the mover that is pushed along the normal, and of the other.
  using Two = double __attribute__((vector_size(16)));
  /// A direction, and what an impulse of 1 Ns along it does to the first and against it to the second.
  struct Axis {
    Vec3 along;           ///< Unit.
    Two arms_m[3];        ///< Of its torques about the movers' pivots,
    Two turns[3];         ///< and what those add to the angular velocities, rad/s.
    double mass_kg;       ///< Effective; 0: neither of the two can go there.
    double perMass_1_kg;  ///< What 1 Ns adds to the speed at which the two part.
    double impulse_Ns;
    double change_Ns;     ///< Of the last round.
    double conjugate_Ns;  ///< The direction of search.
    double begun_Ns;      ///< The step's first guess.
  };

  std::uint16_t a, b;  ///< Movers: pushed along the normal, and against it.
  Axis axes[3];        ///< Along the normal, and two across it.
  double gap_m;
  double friction;
  double rolling_m;
  double before_Ns;       ///< What pressed in the step before.
  double across_1_kg[2];  ///< What a pressing impulse of 1 Ns adds to the velocities across.

  [[nodiscard]] double pressing_Ns() const noexcept { return axes[0].impulse_Ns; }
  /// From the impulses of the last two steps to what the next one begins with: of a blow, the ones before it. A blow is over
  /// with its step, and rounds take it back as slowly as they build it up.
  void guess(double step_s) noexcept;
  [[nodiscard]] Vec3 impulse() const noexcept {
    Vec3 sum(0);
    for (const Axis& axis : axes) sum += axis.impulse_Ns * axis.along;
    return sum;
  }
};

/// Resistance of two bodies' contacts to rolling and spinning on each other.
struct RollingConstraint {
  std::uint16_t a, b;
  std::uint32_t begin, end;  ///< Of the contacts that press.
  glm::dmat3 inertia;        ///< Effective.
  Vec3 turning_Nms;
  Vec3 change_Nms, conjugate_Nms, begun_Nms;
};

/// The spring that pushes overlapping bodies apart.
struct ContactSpring {
  double rate_per_s, massScale, impulseScale;
};

/// Constraints of a tick, solved in turn, in each of its steps.
class ContactSolver {
 public:
  static constexpr std::size_t kMaxContacts = 768;
  static constexpr std::size_t kMaxRolling = kMaxPairs + kMaxMovingBodies;

  ContactSolver(std::span<Mover> movers, const TickSteps& steps) noexcept;

  /// A contact with the impulse that it had in the last tick. False: there is no room.
  [[nodiscard]] bool add(std::uint16_t a, std::uint16_t b, Vec3 place, Vec3 normal, double gap_m, double friction,
                         double rolling_m, Vec3 lastImpulse_Ns) noexcept;
  /// Of the contacts from `begin` on.
  void addRolling(std::uint32_t begin, Vec3 lastTurning_Nms) noexcept;
  /// What the next step begins with.
  void guess() noexcept {
    for (std::uint32_t i = 0; i < count_; ++i) contacts_[i].guess(step_s_);
  }
  /// The movers get it.
  void warmStart() noexcept;
  /// Impulses go towards the step's first guess, as far as that takes energy without the spring: what has pushed bodies apart is
  /// not what holds them.
  void takeBackPush() noexcept;
  /// Rounds of another kind follow.
  void beginRounds() noexcept;
  /// @param soft  Overlap is pushed apart.
  /// @return How much the impulses changed, of what presses.
  double solve(bool soft) noexcept;
  /// Goes on between two rounds as they went before: the nonsmooth nonlinear conjugate gradient method (Silcowitz-Hansen,
  /// Niebe and Erleben 2010), in the norm of energy. A body on which one of R times its mass lies takes some sqrt(R) rounds in place
  /// of R.
  void accelerate() noexcept;
  /// The bodies have moved by a step at the speeds that they have.
  void moved() noexcept;

  [[nodiscard]] std::uint32_t size() const noexcept { return count_; }
  [[nodiscard]] std::uint32_t rollingSize() const noexcept { return rollingCount_; }
  [[nodiscard]] const ContactConstraint& contact(std::uint32_t i) const noexcept { return contacts_[i]; }
  [[nodiscard]] const RollingConstraint& rolling(std::uint32_t i) const noexcept { return rolling_[i]; }

 private:
  using Two = ContactConstraint::Two;

  std::span<Mover> movers_;
  double step_s_;
  ContactSpring spring_;
  std::array<ContactConstraint, kMaxContacts> contacts_;
  std::array<RollingConstraint, kMaxRolling> rolling_;
  std::uint32_t count_ = 0, rollingCount_ = 0;
  std::size_t moverCount_ = 0;  ///< Those beyond touch nothing.
  double change_J_ = 0,
         before_J_ = 0;  ///< The last round's change, squared, and that of the one before it; 0: there was none.

  /// How the two that meet move.
  struct Parting {
    Vec3 linear;
    Two angular[3];

    /// At which they part, m/s.
    [[nodiscard]] double along(const ContactConstraint::Axis& axis) const noexcept {
      const Two turned = axis.arms_m[0] * angular[0] + axis.arms_m[1] * angular[1] + axis.arms_m[2] * angular[2];
      return glm::dot(axis.along, linear) + (turned[0] + turned[1]);
    }
  };
  [[nodiscard]] Parting partingOf(const ContactConstraint& c) const noexcept {
    const Mover &a = movers_[c.a], &b = movers_[c.b];
    const Vec3 first = a.angular(), second = b.angular();
    return {a.linear() - b.linear(), {Two{first.x, second.x}, Two{first.y, second.y}, Two{first.z, second.z}}};
  }
  void push(const ContactConstraint& c, double out_Ns, double left_Ns, double right_Ns) noexcept;
  /// Of the energy, by the part of each constraint's change.
  [[nodiscard]] double slope_J() const noexcept;
  void change(double part) noexcept;
  double solve(ContactConstraint& c, bool soft) noexcept;
  void solve(RollingConstraint& r) noexcept;
  void turn(const RollingConstraint& r, Vec3 impulse_Nms) noexcept {
    movers_[r.a].turn(impulse_Nms);
    movers_[r.b].turn(-impulse_Nms);
  }
};

}  // namespace haptics
