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

Mover::Mover(const RigidBody& body, RigidState& state, const Momenta& before, const TickSteps& steps) noexcept
    : body_(&body), state_(&state), freedom_(body.freedom), steps_(steps) {
  const double part = 1.0 / steps.count;
  if (freedom_ == Freedom::kFree) {
    centre_ = state.centre_m;
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
  anchor_ = toWorld(state.rest, body.joint.anchor_m);
  perAlong_ = 1 / inertiaOnJoint(body, state);
  coordinate_ = state.coordinate;
  rateOfStep_ = part * (state.rate_per_s - before.rate_per_s);
  setRate(before.rate_per_s);
  if (freedom_ == Freedom::kHinge) perInertia_ = perAlong_ * glm::outerProduct(axis_, axis_);
}

void Mover::setRate(double rate_per_s) noexcept {
  rate_ = std::clamp(rate_per_s, (body_->joint.lowest - coordinate_) / steps_.step_s,
                     (body_->joint.highest - coordinate_) / steps_.step_s);
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

Vec3 Mover::velocityAt(Vec3 place) const noexcept {
  return freedom_ == Freedom::kFree ? linear_ + glm::cross(angular_, place - centre_) : rate_ * direction(place);
}

glm::dmat3 Mover::mobility(Vec3 place) const noexcept {
  if (state_ == nullptr) return glm::dmat3(0);
  if (freedom_ != Freedom::kFree) return perAlong_ * glm::outerProduct(direction(place), direction(place));
  const Vec3 r = place - centre_;
  const glm::dmat3 across(0, r.z, -r.y, -r.z, 0, r.x, r.y, -r.x, 0);  // times a vector: r x it
  return glm::dmat3(perMass_) - across * perInertia_ * across;
}

void Mover::push(Vec3 place, Vec3 impulse_Ns) noexcept {
  if (state_ == nullptr) return;
  if (freedom_ != Freedom::kFree) {
    return setRate(rate_ + perAlong_ * glm::dot(direction(place), impulse_Ns));
  }
  const Vec3 turning = glm::cross(place - centre_, impulse_Ns);
  impulse_Ns_ += impulse_Ns;
  impulse_Nms_ += turning;
  linear_ += perMass_ * impulse_Ns;
  angular_ += perInertia_ * turning;
}

void Mover::turn(Vec3 impulse_Nms) noexcept {
  if (state_ == nullptr || freedom_ == Freedom::kSlider) return;
  if (freedom_ == Freedom::kHinge) return setRate(rate_ + perAlong_ * glm::dot(axis_, impulse_Nms));
  impulse_Nms_ += impulse_Nms;
  angular_ += perInertia_ * impulse_Nms;
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
  const Vec3 momentum_Ns = state_->momentum_Ns + impulse_Ns_;
  const Vec3 angularMomentum_Nms = state_->angularMomentum_Nms + impulse_Nms_;
  const MassProperties& mass = body_->mass;
  state_->momentum_Ns = mass.mass_kg / period_s * moved_m_;
  state_->angularMomentum_Nms =
      state_->axes * (mass.moments * (glm::conjugate(state_->axes) * (turned_rad_ / period_s)));
  advanceRigidBody(*body_, *state_, period_s);
  state_->momentum_Ns = momentum_Ns;
  state_->angularMomentum_Nms = angularMomentum_Nms;
}

ContactSolver::ContactSolver(std::span<Mover> movers, const TickSteps& steps) noexcept
    : movers_(movers), step_s_(steps.step_s), spring_(springOf(steps.step_s)) {}

bool ContactSolver::add(std::uint16_t a, std::uint16_t b, Vec3 place, Vec3 normal, double gap_m, double friction,
                        double rolling_m, Vec3 lastImpulse_Ns) noexcept {
  if (count_ == kMaxContacts) return false;
  ContactConstraint& c = contacts_[count_++];
  c.a = a;
  c.b = b;
  c.place = place;
  c.normal = normal;
  const Vec3 aside = std::abs(normal.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  c.along[0] = glm::normalize(glm::cross(normal, aside));
  c.along[1] = glm::cross(normal, c.along[0]);
  c.gap_m = gap_m;
  c.friction = friction;
  c.rolling_m = rolling_m;
  const glm::dmat3 mobility = movers_[a].mobility(place) + movers_[b].mobility(place);
  const auto mass = [](double perMass) { return perMass > 0 ? 1 / perMass : 0; };  // 0: none of the two can go there
  const Vec3 response = mobility * normal;
  c.mass_kg[0] = mass(glm::dot(response, normal));
  c.pressing_Ns = std::max(glm::dot(lastImpulse_Ns, normal), 0.0);
  for (int k = 0; k < 2; ++k) {
    c.mass_kg[k + 1] = mass(glm::dot(mobility * c.along[k], c.along[k]));
    c.across_1_kg[k] = glm::dot(response, c.along[k]);
    c.rubbing_Ns[k] = glm::dot(lastImpulse_Ns, c.along[k]);
  }
  shorten(c.rubbing_Ns, friction * c.pressing_Ns);
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

void ContactSolver::warmStart() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) push(contacts_[i], contacts_[i].impulse());
  for (std::uint32_t i = 0; i < rollingCount_; ++i) {
    movers_[rolling_[i].a].turn(rolling_[i].turning_Nms);
    movers_[rolling_[i].b].turn(-rolling_[i].turning_Nms);
  }
}

double ContactSolver::solve(bool soft) noexcept {
  double change = 0, pressing = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    change += solve(contacts_[i], soft);
    pressing += contacts_[i].pressing_Ns;
  }
  for (std::uint32_t i = 0; i < rollingCount_; ++i) solve(rolling_[i]);
  return pressing > 0 ? change / pressing : 0;
}

void ContactSolver::accelerate() noexcept {
  double squared_J = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    const ContactConstraint& c = contacts_[i];
    for (int k = 0; k < 3; ++k)
      if (c.mass_kg[k] > 0) squared_J += c.change_Ns[k] * c.change_Ns[k] / c.mass_kg[k];
  }
  const double part = squared_J_ > 0 ? squared_J / squared_J_ : 2;
  const bool begins = part > 1;
  squared_J_ = squared_J;
  for (std::uint32_t i = 0; i < count_; ++i) {
    ContactConstraint& c = contacts_[i];
    double more[3];
    for (int k = 0; k < 3; ++k) {
      more[k] = begins ? 0 : part * c.conjugate_Ns[k];
      c.conjugate_Ns[k] = more[k] + c.change_Ns[k];
    }
    if (begins || (more[0] == 0 && more[1] == 0 && more[2] == 0)) continue;
    c.pressing_Ns += more[0];
    c.rubbing_Ns[0] += more[1];
    c.rubbing_Ns[1] += more[2];
    push(c, more[0] * c.normal + more[1] * c.along[0] + more[2] * c.along[1]);
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
  const Vec3 before = velocity(c);
  const double approach = glm::dot(before, c.normal) + closing_m_per_s;
  const double pressing =
      std::max(c.pressing_Ns - c.mass_kg[0] * massScale * approach - impulseScale * c.pressing_Ns, 0.0);
  const double more = pressing - c.pressing_Ns;
  double change = std::abs(more);
  c.pressing_Ns = pressing;
  c.change_Ns[0] = more;
  c.change_Ns[1] = c.change_Ns[2] = 0;
  const bool isOff = pressing == 0 && c.rubbing_Ns[0] == 0 && c.rubbing_Ns[1] == 0;
  if (isOff) {
    if (more != 0) push(c, more * c.normal);
    return change;
  }

  double rubbing[2];
  for (int k = 0; k < 2; ++k) {
    const double sliding = glm::dot(before, c.along[k]) + more * c.across_1_kg[k];
    rubbing[k] = c.rubbing_Ns[k] - c.mass_kg[k + 1] * sliding;
  }
  shorten(rubbing, c.friction * c.pressing_Ns);
  Vec3 impulse = more * c.normal;
  for (int k = 0; k < 2; ++k) {
    impulse += (rubbing[k] - c.rubbing_Ns[k]) * c.along[k];
    c.change_Ns[k + 1] = rubbing[k] - c.rubbing_Ns[k];
    change += std::abs(c.change_Ns[k + 1]);
    c.rubbing_Ns[k] = rubbing[k];
  }
  push(c, impulse);
  return change;
}

void ContactSolver::solve(RollingConstraint& r) noexcept {
  double most = 0;
  for (std::uint32_t i = r.begin; i < r.end; ++i) most += contacts_[i].rolling_m * contacts_[i].pressing_Ns;
  const Vec3 spin = movers_[r.a].angularVelocity() - movers_[r.b].angularVelocity();
  const Vec3 wanted = r.turning_Nms - r.inertia * spin;
  const double size = glm::length(wanted);
  const Vec3 given = size > most ? most / size * wanted : wanted;
  movers_[r.a].turn(given - r.turning_Nms);
  movers_[r.b].turn(r.turning_Nms - given);
  r.turning_Nms = given;
}

void ContactSolver::moved() noexcept {
  for (std::uint32_t i = 0; i < count_; ++i) {
    ContactConstraint& c = contacts_[i];
    c.gap_m += step_s_ * glm::dot(velocity(c), c.normal);
  }
}

}  // namespace haptics
