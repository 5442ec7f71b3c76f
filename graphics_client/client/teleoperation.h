#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace haptics {

/// What one end of a teleoperation sends the other. SI units, one frame for both ends.
struct TeleoperationPacket {
  using Vector = std::array<double, 3>;

  std::uint64_t tick = 0;  ///< Of the end that sends it, from 1.
  Vector place_m{};        ///< Of that end's tip,
  Vector speed_m_per_s{};  ///< and how it moves.
  Vector force_N{};        ///< On that end's tip, by what it touches; a master has none.
  double given_J = 0;      ///< To the other end, since the first tick.
  double spare_J = 0;      ///< What that end could do without; below 0: it lacks so much.
};

/// One end of a robot that a hand leads over a line with delay, jitter and loss: position forth, force back. What the two ends put
/// out never exceeds what the hand and the remote contact have put in, by observer and controller at each end (Hannaford & Ryu
/// 2002) and energy that goes along in the packets (Ryu, Artigas & Preusche 2010; Franken et al. 2011):
/// - The observer adds up the work done on this end, and what the other end has given, which is sent as a sum: a packet that is
///   lost, late or never sent takes nothing away.
/// - The controller shows a force F only where the observer holds the F^2 / 2k of a spring which shows it and would give it all
///   back. It holds without a model of hand, robot or line, and needs no velocity.
/// - What an end can do without it gives to the other one.
/// A packet goes out where the other end would otherwise be wrong by more than a hand notices (the deadband of IEEE 1918.1.1), and
/// every longestSilence_s. SI units. One thread; nothing allocates, locks or throws.
class TeleoperationPort {
 public:
  using Vector = TeleoperationPacket::Vector;

  /// The coupling's, alike at both ends, and this end's own.
  struct Settings {
    double period_s = 1e-3;          ///< Of tick().
    double maxForce_N = 3.3;         ///< Of this end's motors.
    double resolution_m = 0;         ///< Of this end's encoders.
    double stiffness_N_per_m = 600;  ///< Between the master's place and the follower's.
    double damping_Ns_per_m = 10;    ///< Of the follower.
    double noticeable = 0.07;        ///< Least difference of a force that a hand notices, in proportion,
    double noticeable_N = 0.03;      ///< and not below this.
    double longestSilence_s = 0.03;  ///< Between packets. Shorter: more packets, and a lost one is made good sooner.
  };

  /// Of the other end, in any order, each once or more or never. One that is older than another, or not finite, is not taken.
  void receive(const TeleoperationPacket& packet) {
    if (packet.tick <= heard_.tick || !isSound(packet)) return;
    held_J_ += std::max(0.0, packet.given_J - heard_.given_J);
    heard_ = packet;
    heardAt_ = tick_;
  }

  /// By the observer; the two ends' together is never below 0.
  [[nodiscard]] double held_J() const { return held_J_; }
  /// That this observer has seen.
  [[nodiscard]] double lowest_J() const { return lowest_J_; }

 protected:
  /// For the follower to move by. More: the hand is braked for longer before.
  static constexpr double kReserve_J = 4e-3;
  static constexpr double kDeaf_s = 0.5;  ///< Without a packet: forces fade,
  static constexpr double kFade_s = 0.1;  ///< in this time.

  Settings settings_;
  TeleoperationPacket heard_, sent_;
  std::uint64_t tick_ = 0, heardAt_ = 0;
  Vector place_m_{}, speed_m_per_s_{};
  double held_J_ = 0, given_J_ = 0, trust_ = 0;

  explicit TeleoperationPort(const Settings& settings) : settings_(settings) {}

  /// The tip has moved, under the force of the last tick.
  void observe(const Vector& place_m) {
    if (tick_++ == 0) place_m_ = place_m;
    // Of coarse encoders slower: a force that follows their steps costs more than it brings.
    constexpr double kFastest_s = 5e-3, kStep_m_per_s = 2e-3;
    const double share =
        settings_.period_s / (settings_.period_s + std::max(kFastest_s, settings_.resolution_m / kStep_m_per_s));
    for (std::size_t i = 0; i < 3; ++i) {
      const double way_m = place_m[i] - place_m_[i];
      held_J_ -= force_N_[i] * way_m;
      speed_m_per_s_[i] += share * (way_m / settings_.period_s - speed_m_per_s_[i]);
    }
    place_m_ = place_m;
    lowest_J_ = std::min(lowest_J_, held_J_);
    const bool hears = heard_.tick > 0 && unheard_s() < kDeaf_s;
    trust_ = std::clamp(trust_ + (hears ? 1 : -1) * settings_.period_s / kFade_s, 0.0, 1.0);
  }

  [[nodiscard]] double unheard_s() const { return static_cast<double>(tick_ - heardAt_) * settings_.period_s; }

  /// As much of a force as is paid for, by springs of this stiffness.
  [[nodiscard]] Vector paid(const Vector& force_N, double stiffness_N_per_m) {
    const Vector shown_N = shortened(force_N, paid_N(stiffness_N_per_m));
    shown_N_ = length(shown_N);
    return shown_N;
  }

  /// What to keep for a force.
  [[nodiscard]] double priceOf(double force_N, double stiffness_N_per_m) const {
    constexpr double kMore = 1.1;  // it is to stay paid for
    return kMore * (force_N * force_N / (2 * stiffness_N_per_m) + force_N * settings_.resolution_m);
  }

  /// Sends the motors a force. What the tip did within an encoder's step is not known: each change may cost half a step.
  const Vector& write(const Vector& force_N) {
    const Vector written_N = shortened(force_N, settings_.maxForce_N);
    for (std::size_t i = 0; i < 3; ++i) held_J_ -= std::abs(written_N[i] - force_N_[i]) * settings_.resolution_m / 2;
    return force_N_ = written_N;
  }

  void give(double spare_J) {
    held_J_ -= std::max(0.0, spare_J);
    given_J_ += std::max(0.0, spare_J);
  }

  /// What to send now, if anything. @param off_N  How wrong the other end is without, of a force like this one.
  [[nodiscard]] std::optional<TeleoperationPacket> news(double off_N, double force_N, const Vector& contact_N,
                                                        double spare_J) {
    const bool isNoticed = off_N > std::max(settings_.noticeable * force_N, settings_.noticeable_N);
    if (!isNoticed && unsent_s() < settings_.longestSilence_s) return std::nullopt;
    return sent_ = {tick_, place_m_, speed_m_per_s_, contact_N, given_J_, spare_J};
  }
  [[nodiscard]] double unsent_s() const { return static_cast<double>(tick_ - sent_.tick) * settings_.period_s; }

  [[nodiscard]] static double length(const Vector& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
  [[nodiscard]] static Vector difference(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }
  [[nodiscard]] static Vector times(const Vector& v, double factor) {
    return {v[0] * factor, v[1] * factor, v[2] * factor};
  }
  [[nodiscard]] static Vector shortened(const Vector& v, double most) {
    const double all = length(v);
    return all <= most ? v : times(v, most / all);
  }
  /// Where a packet's tip is, so long after it was sent.
  [[nodiscard]] static Vector placeAfter(const TeleoperationPacket& packet, double seconds) {
    return difference(packet.place_m, times(packet.speed_m_per_s, -seconds));
  }

 private:
  Vector force_N_{};
  double lowest_J_ = 0, shown_N_ = 0;

  /// Also where the tip goes on as fast as it does, for a tick in which the spring is not yet shorter; and not up and down with what
  /// each change may cost.
  [[nodiscard]] double paid_N(double stiffness) const {
    const double step_m = length(speed_m_per_s_) * settings_.period_s, half_m = settings_.resolution_m / 2;
    const double has_J = held_J_ - stiffness * step_m * step_m / 2;
    const auto most_N = [stiffness](double energy_J, double each_m) {  // N^2 / 2k + each N = energy
      const double each_N = stiffness * each_m;
      return energy_J > 0 ? std::sqrt(each_N * each_N + 2 * stiffness * energy_J) - each_N : 0.0;
    };
    const double rising_N = most_N(has_J + shown_N_ * half_m, 3 * half_m);
    return rising_N >= shown_N_ ? rising_N : std::min(shown_N_, most_N(has_J - shown_N_ * half_m, half_m));
  }

  [[nodiscard]] static bool isSound(const TeleoperationPacket& packet) {
    double sum = packet.given_J + packet.spare_J;
    for (std::size_t i = 0; i < 3; ++i) sum += packet.place_m[i] + packet.speed_m_per_s[i] + packet.force_N[i];
    return std::isfinite(sum);
  }
};

/// The hand's end.
class MasterPort : public TeleoperationPort {
 public:
  explicit MasterPort(const Settings& settings)
      : TeleoperationPort(settings),
        shown_N_per_m_(
            std::min(kShown_N_per_m, 2 * settings.noticeable_N / std::max(settings.resolution_m, kFinest_m))) {}

  /// @param place_m  Of the device, finite.
  /// @return The force on the hand. What is not paid for does not push the hand, it resists it.
  const Vector& tick(const Vector& place_m) {
    observe(place_m);
    constexpr double kSmooth_s = 3e-3;  // a step of the force that the line makes is felt as a blow
    const double share = settings_.period_s / (settings_.period_s + kSmooth_s);
    for (std::size_t i = 0; i < 3; ++i) heard_N_[i] += share * (trust_ * heard_.force_N[i] - heard_N_[i]);
    const Vector heard_N = shortened(heard_N_, settings_.maxForce_N);
    const Vector shown_N = paid(heard_N, shown_N_per_m_);

    const double speed = length(speed_m_per_s_), missing_N = length(heard_N) - length(shown_N);
    const double lacks = std::clamp(1 - heard_.spare_J / kReserve_J, 0.0, 1.0);
    const double resists = speed > 0 ? std::min(kResists_Ns_per_m, missing_N / speed) : 0;
    const double damping = std::max(lacks * kBrake_Ns_per_m, resists);
    const Vector& written_N = write(difference(shown_N, times(speed_m_per_s_, damping)));

    const double coming_N = std::min(settings_.maxForce_N, std::max(length(heard_N), length(heard_.force_N)));
    const double spare_J = held_J_ - priceOf(coming_N, shown_N_per_m_) - kLeft_J;
    if (lacks > 0) {
      give(spare_J);
    } else {
      held_J_ -= std::max(0.0, spare_J);  // nobody needs it
    }
    return written_N;
  }

  /// After tick().
  [[nodiscard]] std::optional<TeleoperationPacket> send() {
    const double off_m = length(difference(place_m_, placeAfter(sent_, unsent_s())));
    return news(settings_.stiffness_N_per_m * off_m, length(heard_N_), {}, held_J_);
  }

 private:
  /// Of the springs that pay, at most. Larger: less work of the hand for a force, and a harder blow when it is let go.
  static constexpr double kShown_N_per_m = 3000;
  static constexpr double kFinest_m = 1e-9;  ///< Of encoders.
  /// At most. More: it is harder where a wall is known of, and rougher.
  static constexpr double kResists_Ns_per_m = 15;
  static constexpr double kBrake_Ns_per_m = 5;  ///< As long as the follower lacks what it needs to move.
  static constexpr double kLeft_J = 5e-6;

  /// What encoders round is not noticed: a hand that swings at a spring by their steps pays for each.
  double shown_N_per_m_;
  Vector heard_N_{};
};

/// The robot's end. It goes where the master was, as fast as the hand's work allows.
class FollowerPort : public TeleoperationPort {
 public:
  explicit FollowerPort(const Settings& settings) : TeleoperationPort(settings) {}

  /// @param place_m  Of the robot's tip, finite.
  /// @param contact_N  On it, by what it touches, finite.
  /// @return The force for the robot's motors.
  const Vector& tick(const Vector& place_m, const Vector& contact_N) {
    observe(place_m);
    contact_N_ = contact_N;
    const double k = settings_.stiffness_N_per_m;
    const Vector there_m = placeAfter(heard_, std::min(unheard_s(), settings_.longestSilence_s));
    const Vector pull_N = shortened(times(difference(there_m, place_m), trust_ * k), settings_.maxForce_N);
    const Vector& written_N = write(difference(paid(pull_N, k), times(speed_m_per_s_, settings_.damping_Ns_per_m)));
    spare_J_ = held_J_ - priceOf(length(pull_N), k);
    constexpr double kFull = 1.5;
    give(spare_J_ - kFull * kReserve_J);
    return written_N;
  }

  /// After tick().
  [[nodiscard]] std::optional<TeleoperationPacket> send() {
    return news(length(difference(contact_N_, sent_.force_N)), length(sent_.force_N), contact_N_, spare_J_);
  }

 private:
  Vector contact_N_{};
  double spare_J_ = 0;
};

}  // namespace haptics
