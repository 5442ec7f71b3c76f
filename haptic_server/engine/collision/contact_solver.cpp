#include "haptic_server/engine/collision/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic_server/engine/collision/moving_together.h"
#include "haptic_server/engine/motion/joint_motion.h"
#include "haptic_server/engine/motion/rigid_motion.h"

namespace haptics {
namespace {

using Two = ContactConstraint::Two;

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

void Mover::pushOnJoint(Vec3 impulse_Ns, Vec3 turn_rad_per_s) noexcept {
  setRate(rate_ +
          (freedom_ == Freedom::kHinge ? glm::dot(axis_, turn_rad_per_s) : perAlong_ * glm::dot(axis_, impulse_Ns)));
}

void Mover::beginRounds() noexcept {
  linearBefore_ = linear_;
  angularBefore_ = angular_;
}

void Mover::accelerate(double part) noexcept {
  const bool hasDirection = part > 0;
  const Vec3 linear = hasDirection ? part * linearConjugate_ : Vec3(0),
             angular = hasDirection ? part * angularConjugate_ : Vec3(0);
  linearConjugate_ = linear + (linear_ - linearBefore_);
  angularConjugate_ = angular + (angular_ - angularBefore_);
  if (freedom_ == Freedom::kFree) {
    linear_ += linear;
    angular_ += angular;
  } else {
    setRate(rate_ + glm::dot(axis_, linear + angular));
  }
  linearBefore_ = linear_;
  angularBefore_ = angular_;
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
  moverCount_ = std::max<std::size_t>(moverCount_, 1U + std::max(a, b));
  c.gap_m = gap_m;
  c.friction = friction;
  c.rolling_m = rolling_m;
  const Vec3 aside = std::abs(normal.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  c.axes[0].along = normal;
  c.axes[1].along = glm::normalize(glm::cross(normal, aside));
  c.axes[2].along = glm::cross(normal, c.axes[1].along);
  const Mover &first = movers_[a], &second = movers_[b];
  const glm::dmat3 &perInertiaA = first.perInertia(), &perInertiaB = second.perInertia();
  Two perInertia[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) perInertia[i][j] = Two{perInertiaA[i][j], perInertiaB[i][j]};
  }
  const Vec3 armA = place - first.pivot(), armB = second.pivot() - place;
  const Two arm[3] = {{armA.x, armB.x}, {armA.y, armB.y}, {armA.z, armB.z}};
  for (ContactConstraint::Axis& axis : c.axes) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      axis.arms_m[i] = arm[j] * axis.along[k] - axis.along[j] * arm[k];
    }
    for (int i = 0; i < 3; ++i) {
      axis.turns[i] =
          perInertia[0][i] * axis.arms_m[0] + perInertia[1][i] * axis.arms_m[1] + perInertia[2][i] * axis.arms_m[2];
    }
  }
  const auto response = [&](const ContactConstraint::Axis& to, const ContactConstraint::Axis& from) {
    const Two turning = to.arms_m[0] * from.turns[0] + to.arms_m[1] * from.turns[1] + to.arms_m[2] * from.turns[2];
    return glm::dot(to.along, first.perImpulse(from.along) + second.perImpulse(from.along)) + turning[0] + turning[1];
  };
  for (ContactConstraint::Axis& axis : c.axes) {
    const double perMass = response(axis, axis);
    axis.mass_kg = perMass > 0 ? 1 / perMass : 0;
    axis.perMass_1_kg = perMass;
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
  rolling_[rollingCount_++] = {a,       b,       begin,  count_, glm::inverse(perInertia), lastTurning_Nms,
                               Vec3(0), Vec3(0), Vec3(0)};
}

void ContactConstraint::guess(double step_s) noexcept {
  const double pressing_Ns = axes[0].impulse_Ns;
  const double most_Ns = std::max(before_Ns, kBlow_m_per_s2 * step_s * axes[0].mass_kg);
  if (pressing_Ns > most_Ns) {
    for (Axis& axis : axes) axis.impulse_Ns *= most_Ns / pressing_Ns;
  }
  before_Ns = pressing_Ns;
}

[[gnu::always_inline]] inline void ContactSolver::push(const ContactConstraint& c, double out_Ns, double left_Ns,
                                                       double right_Ns) noexcept {
  const auto& [out, left, right] = c.axes;
  const Vec3 impulse = out_Ns * out.along + left_Ns * left.along + right_Ns * right.along;
  Two turns[3];
  for (int i = 0; i < 3; ++i) turns[i] = out_Ns * out.turns[i] + left_Ns * left.turns[i] + right_Ns * right.turns[i];
  movers_[c.a].push(impulse, {turns[0][0], turns[1][0], turns[2][0]});
  movers_[c.b].push(-impulse, {turns[0][1], turns[1][1], turns[2][1]});
}

void ContactSolver::warmStart() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) {
    ContactConstraint& c = contacts_[i];
    c.guess(step_s_);
    push(c, c.axes[0].impulse_Ns, c.axes[1].impulse_Ns, c.axes[2].impulse_Ns);
    for (auto& axis : c.axes) axis.begun_Ns = axis.impulse_Ns;
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) {
    RollingConstraint& r = rolling_[i];
    turn(r, r.turning_Nms);
    r.begun_Nms = r.turning_Nms;
  }
}

void ContactSolver::takeBackPush() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) {
    for (auto& axis : contacts_[i].axes) axis.change_Ns = axis.begun_Ns - axis.impulse_Ns;
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i)
    rolling_[i].change_Nms = rolling_[i].begun_Nms - rolling_[i].turning_Nms;
  const double here_J = slope_J();
  if (!(here_J < 0)) return;
  change(1);
  if (const double there_J = slope_J(); there_J > 0) change(here_J / (here_J - there_J) - 1);
}

double ContactSolver::slope_J() const noexcept {
  double sum_J = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    const ContactConstraint& c = contacts_[i];
    const Parting parting = partingOf(c);
    for (const auto& axis : c.axes) sum_J += axis.change_Ns * parting.along(axis);
    if (c.gap_m > 0) sum_J += c.axes[0].change_Ns * c.gap_m / step_s_;
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) {
    const RollingConstraint& r = rolling_[i];
    sum_J += glm::dot(r.change_Nms, movers_[r.a].angular() - movers_[r.b].angular());
  }
  return sum_J;
}

void ContactSolver::change(double part) noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) {
    auto& [out, left, right] = contacts_[i].axes;
    push(contacts_[i], part * out.change_Ns, part * left.change_Ns, part * right.change_Ns);
    for (auto& axis : contacts_[i].axes) axis.impulse_Ns += part * axis.change_Ns;
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) {
    turn(rolling_[i], part * rolling_[i].change_Nms);
    rolling_[i].turning_Nms += part * rolling_[i].change_Nms;
  }
}

double ContactSolver::solve(bool soft) noexcept {
  double change = 0, pressing = 0;
  change_J_ = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    change += solve(contacts_[i], soft);
    pressing += contacts_[i].pressing_Ns();
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) solve(rolling_[i]);
  return pressing > 0 ? change / pressing : 0;
}

void ContactSolver::beginRounds() noexcept {
  before_J_ = 0;
  for (std::size_t m = 0; m < moverCount_; ++m) movers_[m].beginRounds();
}

void ContactSolver::accelerate() noexcept {
  const bool goesOn = before_J_ > 0 && change_J_ <= before_J_;
  const double part = goesOn ? change_J_ / before_J_ : 0;
  before_J_ = change_J_;
  for (std::uint32_t i = 0; i < count_; ++i) {
    for (auto& axis : contacts_[i].axes) {
      const double more = goesOn ? part * axis.conjugate_Ns : 0;
      axis.conjugate_Ns = more + axis.change_Ns;
      axis.impulse_Ns += more;
    }
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) {
    RollingConstraint& r = rolling_[i];
    const Vec3 more = goesOn ? part * r.conjugate_Nms : Vec3(0);
    r.conjugate_Nms = more + r.change_Nms;
    r.turning_Nms += more;
  }
  for (std::size_t m = 0; m < moverCount_; ++m) movers_[m].accelerate(part);
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
  const Parting parting = partingOf(c);
  ContactConstraint::Axis &out = c.axes[0], &left = c.axes[1], &right = c.axes[2];
  const double pressing = std::max(
      out.impulse_Ns - out.mass_kg * massScale * (parting.along(out) + closing_m_per_s) - impulseScale * out.impulse_Ns,
      0.0);
  out.change_Ns = pressing - out.impulse_Ns;
  left.change_Ns = right.change_Ns = 0;
  if (pressing != 0 || left.impulse_Ns != 0 || right.impulse_Ns != 0) {
    double rubbing[2] = {left.impulse_Ns - left.mass_kg * (parting.along(left) + out.change_Ns * c.across_1_kg[0]),
                         right.impulse_Ns - right.mass_kg * (parting.along(right) + out.change_Ns * c.across_1_kg[1])};
    shorten(rubbing, c.friction * pressing);
    left.change_Ns = rubbing[0] - left.impulse_Ns;
    right.change_Ns = rubbing[1] - right.impulse_Ns;
  } else if (out.change_Ns == 0) {
    return 0;
  }
  out.impulse_Ns = pressing;
  left.impulse_Ns += left.change_Ns;
  right.impulse_Ns += right.change_Ns;
  push(c, out.change_Ns, left.change_Ns, right.change_Ns);
  for (const auto& axis : c.axes) change_J_ += axis.change_Ns * axis.change_Ns * axis.perMass_1_kg;
  return std::abs(out.change_Ns) + std::abs(left.change_Ns) + std::abs(right.change_Ns);
}

void ContactSolver::solve(RollingConstraint& r) noexcept {
  double most = 0;
  for (std::uint32_t i = r.begin; i < r.end; ++i) most += contacts_[i].rolling_m * contacts_[i].pressing_Ns();
  const Vec3 spin = movers_[r.a].angular() - movers_[r.b].angular();
  const Vec3 wanted = r.turning_Nms - r.inertia * spin;
  const double squared = squaredLength(wanted);
  const Vec3 given = squared > most * most ? most / std::sqrt(squared) * wanted : wanted;
  r.change_Nms = given - r.turning_Nms;
  turn(r, r.change_Nms);
  r.turning_Nms = given;
}

void ContactSolver::moved() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i)
    contacts_[i].gap_m += step_s_ * partingOf(contacts_[i]).along(contacts_[i].axes[0]);
}

}  // namespace haptics
