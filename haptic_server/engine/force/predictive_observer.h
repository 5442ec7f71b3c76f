#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>

#include "common/maths/elementary.h"
#include "common/maths/vec.h"

namespace haptics {

/// What the observer knows of a device, and how it is to look.
struct ObserverSettings {
  /// Apparent at the tip, rather too little than too much; 0: not known, and the forces written are not looked at.
  double mass_kg = 0;
  double viscousFriction_Ns_per_m = 0;
  /// From reading a position to the motor's force, beyond the hold. Rather too much than too little: by 2 ms too little no
  /// stiff surface is stable.
  double delay_s = 0;
  /// Triple pole. Higher trusts the encoder more: less of a wrong mass or delay in the force, more of the quantisation.
  double bandwidth_Hz = 80;
  /// The same while no surface is touched, and on those of hardFrom_N_per_m and above; in between by felt stiffness.
  double hardBandwidth_Hz = 80;
  double softUpTo_N_per_m = 0;
  double hardFrom_N_per_m = std::numeric_limits<double>::infinity();  ///< More than softUpTo_N_per_m.
  /// Further lead along the contact normal: damping of K times this. Longer is stabler and tells more of the encoder's
  /// steps.
  double contactLead_s = 1.25e-3;

  bool operator==(const ObserverSettings&) const = default;
};

/// Looks ahead: estimates where the HIP is from quantised positions and the forces that were written, and where it will
/// be in the middle of the time for which the coming force is felt. A spring on that place is one without the delay by
/// which sampling, hold and transport feed energy into it (K T / 2 for the hold alone; Colgate & Schenkel 1997): the
/// force law behind it may be stiffer than any damper would let it be, and needs none.
///
/// How fast it has to follow depends on the spring that is felt: what a wrong mass, friction or delay puts into the estimate
/// comes back through the spring, as K over the mass, while the encoder's steps come into the force as K times them whatever
/// the device. A slow observer is quiet and steady on a soft surface and rings on a hard one; a fast one holds both and tells
/// every step. So the pole follows the felt stiffness, and is fast where nothing is touched: what will be touched is not
/// known, and no force tells of steps. Only the gains change, by which the next errors are weighed: the estimate, and so
/// the force, has no step.
///
/// The estimator is a fading-memory filter of third order with one triple pole (Brookner 1998, section 1.5), driven by
/// the device's known dynamics: position, velocity, and the acceleration that those do not explain, which is the hand's.
/// World frame, SI units; noexcept, no allocation.
class PredictiveObserver {
 public:
  /// Remembered forces: the delay is at most this number of periods less two.
  static constexpr std::size_t kMaxTicks = 64;
  [[nodiscard]] static double longestDelay_s(double period_s) noexcept { return (kMaxTicks - 2) * period_s; }

  PredictiveObserver() noexcept = default;  ///< Not active: positions are felt as measured.
  /// A delay of more than longestDelay_s() is taken as that.
  PredictiveObserver(const ObserverSettings& settings, double period_s) noexcept
      : active_(true),
        period_(period_s),
        friction_(settings.viscousFriction_Ns_per_m),
        inverseMass_(settings.mass_kg > 0 ? 1 / settings.mass_kg : 0),
        contactLead_(settings.contactLead_s),
        softPole_(elementary::exp(-2 * std::numbers::pi * settings.bandwidth_Hz * period_s)),
        hardPole_(elementary::exp(-2 * std::numbers::pi * settings.hardBandwidth_Hz * period_s)),
        softUpTo_(settings.softUpTo_N_per_m),
        polePerStiffness_((hardPole_ - softPole_) / (settings.hardFrom_N_per_m - settings.softUpTo_N_per_m)) {
    setErrorGains(hardPole_);
    const double delay = std::clamp(settings.delay_s, 0.0, longestDelay_s(period_s)) / period_s;
    written_.count = static_cast<std::uint64_t>(delay) + 2;
    older_ = delay - std::floor(delay);
    lead_ = (delay + 0.5) * period_s;
    setForceGains();
  }

  [[nodiscard]] bool active() const noexcept { return active_; }

  /// At rest at this position (m), no force written yet.
  void reset(Vec3 position) noexcept {
    position_ = position;
    velocity_ = acceleration_ = normal_ = pushed_ = Vec3(0);
    surfaceSpeed_ = 0;
    setErrorGains(hardPole_);
    written_.items.fill(Vec3(0));
  }

  /// Takes the position measured this tick (m), returns the place where the force is to be computed. Call
  /// onForceWritten() next.
  [[nodiscard]] Vec3 follow(Vec3 measured) noexcept {
    const Vec3 error = measured - position_;
    position_ += positionGain_ * error;
    velocity_ += velocityGain_ * error;
    acceleration_ += accelerationGain_ * error;
    const Vec3 unpushed = acceleration_ - friction_ * inverseMass_ * velocity_;
    return position_ + lead_ * (velocity_ + lead_ / 2 * unpushed) + pushed_ +
           (contactLead_ * (glm::dot(velocity_, normal_) - surfaceSpeed_)) * normal_;
  }

  /// What the device was given in the end (N), and the normal of the surface that holds the IHIP, zero when free: unit,
  /// geometric, not the shaded one, which turns with the place and would make the lead a source of energy. When free the
  /// last normal stays: without it the HIP would fall back as it leaves a surface and touch it once more, and meet it late
  /// when it comes again, which lets a tap bounce for ever.
  /// @param stiffness_N_per_m  Of that surface, as it is felt.
  /// @param surfaceSpeed_m_per_s  Of that surface along its normal, where it moves: what goes along with it is not led.
  void onForceWritten(Vec3 written_N, Vec3 normal, double stiffness_N_per_m, double surfaceSpeed_m_per_s = 0) noexcept {
    const bool touching = normal != Vec3(0);
    if (touching) normal_ = normal;
    surfaceSpeed_ = surfaceSpeed_m_per_s;
    const double pole = touching ? poleOn(stiffness_N_per_m) : hardPole_;
    if (pole != pole_) setErrorGains(pole);
    advance(written_N);
  }

  /// Ticks that never came: the last force stood. The next position is weighed as by a filter whose period is the time since
  /// the last one: what the encoder's steps made of velocity and acceleration was led for too long to be kept.
  void skip(std::uint64_t ticks) noexcept {
    double pole = pole_;
    for (std::uint64_t i = 0; i < ticks; ++i) {
      advance(written_[newest_]);
      pole *= pole_;
    }
    setErrorGains(pole, static_cast<double>(ticks + 1) * period_);
  }

  /// Whether one that comes from elsewhere could have come of another, by following positions and forces.
  [[nodiscard]] bool couldBecome(const PredictiveObserver& later) const noexcept {
    return later.active_ == active_ && later.written_.count == written_.count && later.newest_ < written_.count;
  }

  /// m/s.
  [[nodiscard]] Vec3 velocity() const noexcept { return velocity_; }

  HAPTICS_FIELDS(self.active_, self.newest_, self.period_, self.friction_, self.inverseMass_, self.contactLead_,
                 self.softPole_, self.hardPole_, self.softUpTo_, self.polePerStiffness_, self.pole_, self.positionGain_,
                 self.velocityGain_, self.accelerationGain_, self.lead_, self.older_, self.position_, self.velocity_,
                 self.acceleration_, self.pushed_, self.normal_, self.surfaceSpeed_, self.weights_, self.written_);

 private:
  [[nodiscard]] std::uint64_t next(std::uint64_t i) const noexcept { return i + 1 == written_.count ? 0 : i + 1; }

  [[nodiscard]] double poleOn(double stiffness_N_per_m) const noexcept {
    const double over_N_per_m = std::max(stiffness_N_per_m - softUpTo_, 0.0);
    return std::max(softPole_ + polePerStiffness_ * over_N_per_m, hardPole_);
  }

  void setErrorGains(double pole) noexcept { setErrorGains(pole, period_); }
  void setErrorGains(double pole, double interval_s) noexcept {
    pole_ = pole;
    const double rest = 1 - pole;
    positionGain_ = 1 - pole * pole * pole;
    velocityGain_ = 1.5 * (1 - pole * pole) * rest / interval_s;
    accelerationGain_ = rest * rest * rest / (interval_s * interval_s);
  }

  void advance(Vec3 written_N) noexcept {
    newest_ = next(newest_);
    written_[newest_] = written_N;
    const std::uint64_t oldest = next(newest_);
    const Vec3 felt_N = glm::mix(written_[next(oldest)], written_[oldest], older_);
    const Vec3 acceleration = (felt_N - friction_ * velocity_) * inverseMass_ + acceleration_;
    position_ += period_ * (velocity_ + period_ / 2 * acceleration);
    velocity_ += period_ * acceleration;
    pushed_ = Vec3(0);
    std::uint64_t i = oldest;
    for (std::uint64_t age = written_.count; age-- > 0; i = next(i)) pushed_ += weights_[age] * written_[i];
  }

  /// How far each of the forces moves the mass in the time that is looked ahead. They act one after another, each for a
  /// period, from the one that is felt now; the coming one, felt at the end, is taken to be as the last.
  void setForceGains() noexcept {
    const auto whole = static_cast<int>(written_.count) - 2;
    double left = lead_;
    for (int tick = 0; left > 0; ++tick, left -= period_) {
      const double part = std::min(left, period_);
      const double weight = inverseMass_ * part * (left - part / 2);
      weights_[static_cast<std::size_t>(std::max(whole - 1 - tick, 0))] += (1 - older_) * weight;
      weights_[static_cast<std::size_t>(std::max(whole - tick, 0))] += older_ * weight;
    }
  }

  Word<bool> active_ = false;
  std::uint64_t newest_ = 0;
  double period_ = 1e-3;
  double friction_ = 0, inverseMass_ = 0, contactLead_ = 0;
  double softPole_ = 0, hardPole_ = 0;  // in z
  double softUpTo_ = 0;                 // N/m
  double polePerStiffness_ = 0;         // m/N
  double pole_ = 0;
  double positionGain_ = 1, velocityGain_ = 0, accelerationGain_ = 0;
  double lead_ = 0;   // s
  double older_ = 0;  // the part that the earlier of two forces has, between which the delay falls
  Vec3 position_{0}, velocity_{0},
      acceleration_{0};  // as measured up to follow(), as expected next after onForceWritten()
  Vec3 pushed_{0};       // m, by the forces in the time that is looked ahead
  Vec3 normal_{0};
  double surfaceSpeed_ = 0;                                     // m/s
  std::array<double, kMaxTicks> weights_{};                     // m/N, by age
  Sequence<Vec3, kMaxTicks> written_{.count = 2, .items = {}};  // a ring
};
static_assert(std::is_trivially_copyable_v<PredictiveObserver> && fields::isListed<PredictiveObserver>());

}  // namespace haptics
