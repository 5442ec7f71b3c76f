#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "client.h"

namespace haptics {

/// The port between the hand and one body that another physics engine moves, slower than the servo and later: the engine's poses
/// go to the server (Client::drive()), and the body is given what the hand does to it. A spring of the stiffness K whose force
/// comes T late gives energy as a damper of -K T would; this one is added, for the engine to integrate implicitly, as long as the
/// body is touched. An observer counts what the engine puts in and what the hand gets, and a controller adds to the damper as much as
/// is missing (Hannaford & Ryu 2002). SI units, world frame. One thread.
class GuestPort {
 public:
  using Vector = Client::Vector;

  struct Settings {
    std::uint64_t body = 0;        ///< Its number in the server's scene.
    double stiffness_N_per_m = 0;  ///< Of its material there.
    double exchange_s = 0;         ///< From pose to pose.
    double late_s = 0;             ///< Of force and pose, there and back, beyond that.
  };

  /// What acts on the body until the next exchange.
  struct Wrench {
    Vector force_N{};  ///< At the place.
    Vector place_m{};
    double damping_Ns_per_m =
        0;  ///< Of its centre's motion; of its rotation about that, times the square of the place's distance.
  };

  explicit GuestPort(const Settings& settings) : settings_(settings) {}

  /// Every tick, in order. Over ticks that were missed or lost the force counts as if it had changed evenly on the hand's way, as a
  /// spring's does.
  void add(const Client::Tick& tick) {
    const bool touches = tick.touched == settings_.body;
    const Vector now_N = touches ? tick.force_N : Vector{};
    if (!follows_) put_J_ += dot(now_N, now_N) / (2 * settings_.stiffness_N_per_m);  // the spring holds it already
    for (std::size_t i = 0; i < 3; ++i) {
      if (follows_) given_J_ += (now_N[i] + hand_N_[i]) / 2 * (tick.hip_m[i] - hip_m_[i]);
      sum_N_[i] -= now_N[i];
    }
    follows_ = true;
    hand_N_ = now_N;
    hip_m_ = tick.hip_m;
    if (touches) wrench_.place_m = tick.ihip_m;
    ++ticks_;
  }

  /// At an exchange: the mean of the ticks that were added since the last one; as before where there were none.
  const Wrench& exchange() {
    if (ticks_ > 0) {
      bool acts = false;
      for (std::size_t i = 0; i < 3; ++i) {
        wrench_.force_N[i] = sum_N_[i] / ticks_;
        acts = acts || wrench_.force_N[i] != 0;
      }
      touched_ = acts;
    }
    sum_N_ = {};
    ticks_ = 0;
    sinceTouched_s_ = touched_ ? 0 : sinceTouched_s_ + settings_.exchange_s;
    const bool isLate = sinceTouched_s_ <= lag_s();  // what the hand did last is still on its way
    wrench_.damping_Ns_per_m = (isLate ? settings_.stiffness_N_per_m * lag_s() : 0) + missing_Ns_per_m();
    way_m_ = {};
    way2_m2_ = 0;
    return wrench_;
  }

  /// The engine has moved the body for `seconds`, under the wrench: its centre by `way_m`, about it by `turn_rad`.
  /// @param arm_m  From the centre to the place.
  void moved(const Vector& way_m, const Vector& turn_rad, const Vector& arm_m, double seconds) {
    const Vector carried{turn_rad[1] * arm_m[2] - turn_rad[2] * arm_m[1],
                         turn_rad[2] * arm_m[0] - turn_rad[0] * arm_m[2],
                         turn_rad[0] * arm_m[1] - turn_rad[1] * arm_m[0]};
    const double way2 = dot(way_m, way_m) + dot(arm_m, arm_m) * dot(turn_rad, turn_rad);
    put_J_ -= dot(wrench_.force_N, way_m) + dot(wrench_.force_N, carried);
    put_J_ += wrench_.damping_Ns_per_m * way2 / seconds;
    for (std::size_t i = 0; i < 3; ++i) way_m_[i] += way_m[i] + carried[i];
    way2_m2_ += way2;
    lowest_J_ = std::min(lowest_J_, energy_J());
  }

  [[nodiscard]] const Wrench& wrench() const { return wrench_; }  ///< Of the last exchange.
  /// What engine and hand have put in, the spring's included, and not got back; below 0 the port would have made energy.
  [[nodiscard]] double energy_J() const { return put_J_ - given_J_; }
  [[nodiscard]] double lowest_J() const { return lowest_J_; }
  [[nodiscard]] const Settings& settings() const { return settings_; }

 private:
  static constexpr double kMaxDamping_Ns_per_m = 1e4;

  Settings settings_;
  Wrench wrench_;
  Vector sum_N_{};
  int ticks_ = 0;
  bool touched_ = false, follows_ = false;
  double sinceTouched_s_ = std::numeric_limits<double>::infinity();
  Vector hand_N_{}, hip_m_{};  // of the last tick: the force on the hand, where the body gives it
  double given_J_ = 0, put_J_ = 0, lowest_J_ = 0;
  Vector way_m_{};  // of the place, since the exchange
  double way2_m2_ = 0;

  /// The server comes to a pose an exchange after it, and the force is of the exchange before, for the next one.
  [[nodiscard]] double lag_s() const { return 3 * settings_.exchange_s + settings_.late_s; }
  /// So that the body, moving as it did last, takes no more than there is. What the spring holds is the hand's, which may go back
  /// before it is heard of.
  [[nodiscard]] double missing_Ns_per_m() const {
    const double held_J = dot(wrench_.force_N, wrench_.force_N) / (2 * settings_.stiffness_N_per_m);
    const double lacks_J = std::max(0.0, dot(wrench_.force_N, way_m_)) + held_J - energy_J();
    const double per_damping = way2_m2_ / settings_.exchange_s;  // J for each N s/m
    if (lacks_J <= 0 || way2_m2_ == 0) return 0;
    return std::min(kMaxDamping_Ns_per_m, lacks_J / std::max(per_damping, std::numeric_limits<double>::min()));
  }
  [[nodiscard]] static double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
};

}  // namespace haptics
