#include "tests/eval/stability/support.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "haptic_server/engine/motion/rigid_motion.h"
#include "tests/eval/stability/linear_loop.h"

namespace haptics::eval {
namespace {

constexpr unsigned kFalloffDegree = 2;

/// Over a period, exactly: how a velocity and a force become place and velocity.
struct Glide {
  double way, fade, shifted, pushed;

  explicit Glide(const SampledLoop& loop) {
    const double t = loop.period_s, m = loop.mass_kg, b = loop.viscousFriction_Ns_per_m;
    const double rate = b / m;
    fade = std::exp(-rate * t);
    way = rate > 0 ? (1 - fade) / rate : t;
    pushed = rate > 0 ? (1 - fade) / b : t / m;
    shifted = rate > 0 ? (t - way) / b : t * t / (2 * m);
  }
};

/// State at a tick: position, velocity, two of the footing, and the forces still on their way, the newest first.
class Transition {
 public:
  Transition(const SampledLoop& loop, const Support& support, double stiffness)
      : loop_(loop),
        delay_(static_cast<Eigen::Index>(std::lround(loop.delay_s / loop.period_s))),
        a_(Eigen::MatrixXd::Zero(4 + delay_, 4 + delay_)) {
    support.mass_kg > 0 ? addBody(support, stiffness) : addTissue(support, stiffness);
    addDevice();
  }
  [[nodiscard]] bool isStable() const { return a_.eigenvalues().cwiseAbs().maxCoeff() <= 1; }

 private:
  /// The step's: the force of this tick on the body as it stood, then semi-implicit (rigid_motion.h).
  void addBody(const Support& support, double stiffness) {
    force_ = {-stiffness, 0, stiffness, 0};
    const double t = loop_.period_s;
    const double slower = 1 / (1 + t * support.damping_Ns_per_m / support.mass_kg);
    const double drive = slower * t / support.mass_kg;
    const double speed[] = {drive * stiffness, 0, -drive * (stiffness + support.stiffness_N_per_m), slower};
    for (Eigen::Index i = 0; i < 4; ++i) {
      a_(3, i) = speed[i];
      a_(2, i) = t * speed[i];
    }
    a_(2, 2) += 1;
  }

  /// The tissue yields within the tick: w' = (1 - f) s x + f w.
  void addTissue(const Support& support, double stiffness) {
    const double share = stiffness / (stiffness + support.stiffness_N_per_m);
    const double left = support.returnTime_s > 0 ? std::exp(-loop_.period_s / (support.returnTime_s * (1 - share))) : 0;
    a_(2, 0) = (1 - left) * share;
    a_(2, 2) = left;
    force_ = {-stiffness * (1 - a_(2, 0)), 0, stiffness * left, 0};
  }

  void addDevice() {
    const Glide glide(loop_);
    a_(0, 0) = 1;
    a_(0, 1) = glide.way;
    a_(1, 1) = glide.fade;
    if (delay_ > 0) {
      a_(0, 3 + delay_) = glide.shifted;
      a_(1, 3 + delay_) = glide.pushed;
      for (Eigen::Index i = 1; i < delay_; ++i) a_(4 + i, 3 + i) = 1;
    }
    for (Eigen::Index i = 0; i < 4; ++i) {
      if (delay_ > 0) {
        a_(4, i) = force_[static_cast<std::size_t>(i)];
      } else {
        a_(0, i) += glide.shifted * force_[static_cast<std::size_t>(i)];
        a_(1, i) += glide.pushed * force_[static_cast<std::size_t>(i)];
      }
    }
  }

  const SampledLoop& loop_;
  Eigen::Index delay_;
  Eigen::MatrixXd a_;
  std::array<double, 4> force_{};  // of this tick, by the state
};

/// The production body under the spring.
class Body {
 public:
  Body(const Support& support, double period_s)
      : body_(bodyOf(support, {1, 0, 0})), state_(restingAt(body_, {})), period_(period_s) {}
  double operator()(double x, double stiffness) {
    const double pressed_m = x - state_.coordinate;
    MotionAllowance endless;
    moveRigidBody(body_, state_, {Vec3(stiffness * pressed_m, 0, 0), Vec3(0)}, period_, endless);
    return pressed_m;
  }

 private:
  RigidBody body_;
  RigidState state_;
  double period_;
};

/// The production tissue.
class Tissue {
 public:
  Tissue(const Support& support, double period_s) : tissue_(tissueOf(support, 1)), period_(period_s) {}
  double operator()(double x, double stiffness) {
    yielded_m_ = tissue_.yield_m(yielded_m_, x, stiffness, period_);
    return x - yielded_m_;
  }

 private:
  SoftTissue tissue_;
  double period_;
  double yielded_m_ = 0;
};

Record compared(std::string_view scene, const SampledLoop& loop, const Support& support) {
  constexpr double kAllowedOff = 0.1;
  const Stand stand = [&]() -> std::function<double(double, double)> {
    if (support.mass_kg > 0) return Body(support, loop.period_s);
    return Tissue(support, loop.period_s);
  };
  const double exact = exactLimit_N_per_m(loop, support);
  const double simulated = simulatedLimit_N_per_m(loop, stand, support.stiffness_N_per_m, kStiffest_N_per_m);
  const double off = simulated / exact - 1;
  return {{"method", "simulated_plant"},  {"scene", scene},
          {"mass_kg", loop.mass_kg},      {"b_Ns_per_m", loop.viscousFriction_Ns_per_m},
          {"rate_Hz", 1 / loop.period_s}, {"delay_ms", loop.delay_s * 1e3},
          {"predicted", exact},           {"simulated", simulated},
          {"difference_ratio", off},      {"pass", std::abs(off) <= kAllowedOff}};
}

}  // namespace

Support bodySupport() noexcept { return {0.1, 500, 5, 0}; }
Support viscousSupport() noexcept { return {0, 500, 0, 0.05}; }
Support elasticSupport() noexcept { return {0, 500, 0, 0}; }

RigidBody bodyOf(const Support& support, Vec3 axis) noexcept {
  RigidBody body;
  body.mass.mass_kg = support.mass_kg;
  body.gravity_m_per_s2 = Vec3(0);
  body.freedom = Freedom::kSlider;
  body.joint.axis = axis;
  body.spring.stiffness_N_per_m = support.stiffness_N_per_m;
  body.spring.damping_Ns_per_m = support.damping_Ns_per_m;
  return body;
}

SoftTissue tissueOf(const Support& support, double radius_m) noexcept {
  return {Falloff(radius_m, kFalloffDegree), support.stiffness_N_per_m, support.returnTime_s};
}

double exactLimit_N_per_m(const SampledLoop& loop, const Support& support) {
  constexpr double kMin_N_per_m = 0.1;
  constexpr double kClimb = 1.1;
  constexpr int kHalvings = 60;
  const auto isStable = [&](double stiffness) { return Transition(loop, support, stiffness).isStable(); };
  if (!isStable(kMin_N_per_m)) return 0;
  double unstable = kMin_N_per_m;
  do {
    unstable *= kClimb;
    if (unstable > kStiffest_N_per_m) return kStiffest_N_per_m;
  } while (isStable(unstable));
  double stable = unstable / kClimb;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (stable + unstable) / 2;
    (isStable(middle) ? stable : unstable) = middle;
  }
  return stable;
}

std::vector<Record> compareFootings() {
  std::vector<Record> records;
  for (const double b : {0.05, 0.5}) {
    for (const double rate : {1e3, 4e3}) {
      for (const double delay_s : {0.0, 1e-3}) {
        const SampledLoop loop{0.075, b, 0, 1 / rate, delay_s};
        records.push_back(compared("eigenvalues_on_a_body_N_per_m", loop, bodySupport()));
        records.push_back(compared("eigenvalues_on_viscous_tissue_N_per_m", loop, viscousSupport()));
      }
    }
  }
  return records;
}

}  // namespace haptics::eval
