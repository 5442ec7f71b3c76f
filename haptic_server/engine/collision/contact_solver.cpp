#include "haptic_server/engine/collision/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic_server/engine/collision/moving_together.h"
#include "haptic_server/engine/motion/joint_motion.h"
#include "haptic_server/engine/motion/rigid_motion.h"

namespace haptics {
namespace {

// The spring that pushes overlapping bodies apart (Catto 2024): stiffer ones overshoot, softer ones let bodies at rest sink
// in by more. At 1 kHz a body lies 4 um deep.
constexpr double kStepsOfSpring = 2;  ///< Of its period; fewer cannot be followed.
constexpr double kDampingRatio = 10;
/// Overlap that is left alone, m: 0 would let points at rest come and go.
constexpr double kSlop_m = 1e-6;
/// What a step gives of more than that may be a blow: 50 weights. Smaller takes the first guess from heaps.
constexpr double kBlow_m_per_s2 = 500;

[[nodiscard]] constexpr ContactSpring springOf(double step_s) noexcept {
  const double omega = 2 * std::numbers::pi / (kStepsOfSpring * step_s);
  const double a = 2 * kDampingRatio + step_s * omega;
  const double b = step_s * omega * a;
  return {omega / a, b / (1 + b), 1 / (1 + b)};
}

/// No longer than `most`.
void shorten(double (&v)[2], double most) noexcept {
  const double squared = v[0] * v[0] + v[1] * v[1];
  if (squared <= most * most) return;
  const double part = most / std::sqrt(squared);
  for (double& each : v) each *= part;
}

}  // namespace

Mover::Mover(const RigidBody& body, RigidState& state, const Momenta& before, const TickSteps& steps) noexcept {
  *this = Mover();
  body_ = &body;
  state_ = &state;
  freedom_ = body.freedom;
  steps_ = steps;
  const double part = 1.0 / steps.count;
  if (freedom_ == Freedom::kFree) {
    pivot_ = state.centre_m;
    perMass_ = 1 / body.mass.mass_kg;
    const glm::dmat3 turn = glm::mat3_cast(state.axes);
    const Vec3 m = body.mass.moments;
    perInertia_ = glm::dmat3(turn[0] / m.x, turn[1] / m.y, turn[2] / m.z) * glm::transpose(turn);
    linear_ = perMass_ * before.momentum_Ns;
    angular_ = perInertia_ * before.angularMomentum_Nms;
    linearOfStep_ = part * perMass_ * (state.momentum_Ns - before.momentum_Ns);
    angularOfStep_ = part * (perInertia_ * (state.angularMomentum_Nms - before.angularMomentum_Nms));
    return;
  }
  axis_ = state.rest.rotation * body.joint.axis;
  pivot_ = toWorld(state.rest, body.joint.anchor_m);
  perAlong_ = 1 / inertiaOnJoint(body, state);
  coordinate_ = state.coordinate;
  rateOfStep_ = part * (state.rate_per_s - before.rate_per_s);
  setRate(before.rate_per_s);
  if (freedom_ == Freedom::kHinge) perInertia_ = perAlong_ * glm::outerProduct(axis_, axis_);
}

void Mover::setRate(double rate_per_s) noexcept {
  rate_ = std::clamp(rate_per_s, (body_->joint.lowest - coordinate_) / steps_.step_s,
                     (body_->joint.highest - coordinate_) / steps_.step_s);
  (freedom_ == Freedom::kHinge ? angular_ : linear_) = rate_ * axis_;
}

void Mover::drive() noexcept {
  if (state_ == nullptr) return;
  if (freedom_ != Freedom::kFree) return setRate(rate_ + rateOfStep_);
  linear_ += linearOfStep_;
  angular_ += angularOfStep_;
}

void Mover::move() noexcept {
  if (state_ == nullptr) return;
  if (freedom_ != Freedom::kFree) {
    coordinate_ += steps_.step_s * rate_;
    return setRate(rate_);
  }
  moved_m_ += steps_.step_s * linear_;
  turned_rad_ += steps_.step_s * angular_;
}

double Mover::energy_J() const noexcept {
  if (state_ == nullptr) return 0;
  if (freedom_ != Freedom::kFree) return rate_ * rate_ / (2 * perAlong_);
  const Vec3 turning = glm::conjugate(state_->axes) * angular_;
  return 0.5 * (squaredLength(linear_) / perMass_ + glm::dot(body_->mass.moments * turning, turning));
}

void Mover::slow(double part) noexcept {
  if (state_ == nullptr) return;
  if (freedom_ != Freedom::kFree) return setRate(part * rate_);
  linear_ *= part;
  angular_ *= part;
}

void Mover::push(Vec3 impulse_Ns, Vec3 turn_rad_per_s) noexcept {
  if (state_ == nullptr) return;
  if (freedom_ == Freedom::kHinge) return setRate(rate_ + glm::dot(axis_, turn_rad_per_s));
  if (freedom_ == Freedom::kSlider) return setRate(rate_ + perAlong_ * glm::dot(axis_, impulse_Ns));
  linear_ += perMass_ * impulse_Ns;
  angular_ += turn_rad_per_s;
}

void Mover::give() noexcept {
  if (state_ == nullptr) return;
  const double period_s = steps_.period_s();
  if (freedom_ != Freedom::kFree) {
    state_->rate_per_s = (coordinate_ - state_->coordinate) / period_s;
    advanceRigidBody(*body_, *state_, period_s);
    state_->rate_per_s = rate_;
    return;
  }
  const MassProperties& mass = body_->mass;
  const Quat axes = state_->axes;
  const auto angularMomentum = [&](Vec3 angular) { return axes * (mass.moments * (glm::conjugate(axes) * angular)); };
  state_->momentum_Ns = mass.mass_kg / period_s * moved_m_;
  state_->angularMomentum_Nms = angularMomentum(turned_rad_ / period_s);
  advanceRigidBody(*body_, *state_, period_s);
  state_->momentum_Ns = mass.mass_kg * linear_;
  state_->angularMomentum_Nms = angularMomentum(angular_);
}

ContactSolver::ContactSolver(std::span<Mover> movers, const TickSteps& steps) noexcept
    : movers_(movers), step_s_(steps.step_s), spring_(springOf(steps.step_s)) {}

bool ContactSolver::add(std::uint16_t a, std::uint16_t b, Vec3 place, Vec3 normal, double gap_m, double friction,
                        double rolling_m, Vec3 lastImpulse_Ns) noexcept {
  if (count_ == kMaxContacts) return false;
  ContactConstraint& c = contacts_[count_++];
  c.a = a;
  c.b = b;
  c.gap_m = gap_m;
  c.friction = friction;
  c.rolling_m = rolling_m;
  const Vec3 aside = std::abs(normal.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  c.axes[0].along = normal;
  c.axes[1].along = glm::normalize(glm::cross(normal, aside));
  c.axes[2].along = glm::cross(normal, c.axes[1].along);
  const Mover &first = movers_[a], &second = movers_[b];
  const glm::dmat3 perInertiaA = first.perInertia(), perInertiaB = second.perInertia();
  const Vec3 armA = place - first.pivot(), armB = place - second.pivot();
  for (ContactConstraint::Axis& axis : c.axes) {
    axis.armA = glm::cross(armA, axis.along);
    axis.armB = glm::cross(armB, axis.along);
    axis.turnA = perInertiaA * axis.armA;
    axis.turnB = perInertiaB * axis.armB;
  }
  const auto response = [&](const ContactConstraint::Axis& to, const ContactConstraint::Axis& from) {
    return glm::dot(to.along, first.perImpulse(from.along) + second.perImpulse(from.along)) +
           glm::dot(to.armA, from.turnA) + glm::dot(to.armB, from.turnB);
  };
  for (ContactConstraint::Axis& axis : c.axes) {
    const double perMass = response(axis, axis);
    axis.mass_kg = perMass > 0 ? 1 / perMass : 0;
    axis.impulse_Ns = glm::dot(lastImpulse_Ns, axis.along);
  }
  for (int k = 0; k < 2; ++k) c.across_1_kg[k] = response(c.axes[k + 1], c.axes[0]);
  c.axes[0].impulse_Ns = std::max(c.axes[0].impulse_Ns, 0.0);
  double rubbing[2] = {c.axes[1].impulse_Ns, c.axes[2].impulse_Ns};
  shorten(rubbing, friction * c.pressing_Ns());
  for (int k = 0; k < 2; ++k) c.axes[k + 1].impulse_Ns = rubbing[k];
  c.before_Ns = c.pressing_Ns();
  return true;
}

void ContactSolver::addRolling(std::uint32_t begin, Vec3 lastTurning_Nms) noexcept {
  const auto presses = [](const ContactConstraint& c) { return c.rolling_m > 0; };
  if (rollingCount_ == kMaxRolling || std::none_of(contacts_.begin() + begin, contacts_.begin() + count_, presses))
    return;
  const std::uint16_t a = contacts_[begin].a, b = contacts_[begin].b;
  const glm::dmat3 perInertia = movers_[a].perInertia() + movers_[b].perInertia();
  const double determinant = glm::determinant(perInertia);
  if (!(std::abs(determinant) > 0)) return;  // on a joint
  rolling_[rollingCount_++] = {a, b, begin, count_, glm::inverse(perInertia), lastTurning_Nms};
}

void ContactConstraint::guess(double step_s) noexcept {
  const double pressing_Ns = axes[0].impulse_Ns;
  const double most_Ns = std::max(before_Ns, kBlow_m_per_s2 * step_s * axes[0].mass_kg);
  if (pressing_Ns > most_Ns) {
    for (Axis& axis : axes) axis.impulse_Ns *= most_Ns / pressing_Ns;
  }
  before_Ns = pressing_Ns;
}

void ContactSolver::push(const ContactConstraint& c, const double (&impulse_Ns)[3]) noexcept {
  Vec3 sum(0), turnA(0), turnB(0);
  for (int k = 0; k < 3; ++k) {
    if (impulse_Ns[k] == 0) continue;
    sum += impulse_Ns[k] * c.axes[k].along;
    turnA += impulse_Ns[k] * c.axes[k].turnA;
    turnB += impulse_Ns[k] * c.axes[k].turnB;
  }
  movers_[c.a].push(sum, turnA);
  movers_[c.b].push(-sum, -turnB);
}

void ContactSolver::warmStart() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) {
    contacts_[i].guess(step_s_);
    const auto& axes = contacts_[i].axes;
    push(contacts_[i], {axes[0].impulse_Ns, axes[1].impulse_Ns, axes[2].impulse_Ns});
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) turn(rolling_[i], rolling_[i].turning_Nms);
}

double ContactSolver::solve(bool soft) noexcept {
  double change = 0, pressing = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    change += solve(contacts_[i], soft);
    pressing += contacts_[i].pressing_Ns();
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) solve(rolling_[i]);
  return pressing > 0 ? change / pressing : 0;
}

void ContactSolver::accelerate() noexcept {
  double squared_J = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    for (const auto& axis : contacts_[i].axes) {
      if (axis.mass_kg > 0) squared_J += axis.change_Ns * axis.change_Ns / axis.mass_kg;
    }
  }
  const double part = squared_J_ > 0 ? squared_J / squared_J_ : 2;
  const bool goesOn = part <= 1;
  squared_J_ = squared_J;
  for (std::uint32_t i = 0; i < count_; ++i) {
    double more[3];
    for (int k = 0; k < 3; ++k) {
      ContactConstraint::Axis& axis = contacts_[i].axes[k];
      more[k] = goesOn ? part * axis.conjugate_Ns : 0;
      axis.conjugate_Ns = more[k] + axis.change_Ns;
      axis.impulse_Ns += more[k];
    }
    if (more[0] != 0 || more[1] != 0 || more[2] != 0) push(contacts_[i], more);
  }
}

double ContactSolver::solve(ContactConstraint& c, bool soft) noexcept {
  double closing_m_per_s = 0, massScale = 1, impulseScale = 0;
  if (c.gap_m > 0) {
    closing_m_per_s = c.gap_m / step_s_;
  } else if (soft) {
    closing_m_per_s = std::max(spring_.rate_per_s * std::min(c.gap_m + kSlop_m, 0.0), -kPushApart_m_per_s);
    massScale = spring_.massScale;
    impulseScale = spring_.impulseScale;
  }
  ContactConstraint::Axis& out = c.axes[0];
  const double approach = velocity(c, out) + closing_m_per_s;
  const double pressing =
      std::max(out.impulse_Ns - out.mass_kg * massScale * approach - impulseScale * out.impulse_Ns, 0.0);
  double change[3] = {pressing - out.impulse_Ns, 0, 0};
  if (pressing != 0 || c.axes[1].impulse_Ns != 0 || c.axes[2].impulse_Ns != 0) {
    double rubbing[2];
    for (int k = 0; k < 2; ++k) {
      const ContactConstraint::Axis& across = c.axes[k + 1];
      const double sliding = velocity(c, across) + change[0] * c.across_1_kg[k];
      rubbing[k] = across.impulse_Ns - across.mass_kg * sliding;
    }
    shorten(rubbing, c.friction * pressing);
    for (int k = 0; k < 2; ++k) change[k + 1] = rubbing[k] - c.axes[k + 1].impulse_Ns;
  }
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    c.axes[k].impulse_Ns += change[k];
    c.axes[k].change_Ns = change[k];
    sum += std::abs(change[k]);
  }
  out.impulse_Ns = pressing;
  if (sum > 0) push(c, change);
  return sum;
}

void ContactSolver::solve(RollingConstraint& r) noexcept {
  double most = 0;
  for (std::uint32_t i = r.begin; i < r.end; ++i) most += contacts_[i].rolling_m * contacts_[i].pressing_Ns();
  const Vec3 spin = movers_[r.a].angular() - movers_[r.b].angular();
  const Vec3 wanted = r.turning_Nms - r.inertia * spin;
  const double size = glm::length(wanted);
  const Vec3 given = size > most ? most / size * wanted : wanted;
  turn(r, given - r.turning_Nms);
  r.turning_Nms = given;
}

void ContactSolver::turn(const RollingConstraint& r, Vec3 impulse_Nms) noexcept {
  movers_[r.a].push(Vec3(0), movers_[r.a].perInertia() * impulse_Nms);
  movers_[r.b].push(Vec3(0), -(movers_[r.b].perInertia() * impulse_Nms));
}

void ContactSolver::moved() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) {
    ContactConstraint& c = contacts_[i];
    c.gap_m += step_s_ * velocity(c, c.axes[0]);
  }
}

}  // namespace haptics
