#include "tests/eval/stability/linear_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "haptic_server/device/plant.h"

namespace haptics::eval {
namespace {

constexpr int kSubsteps = 20;  ///< Of a period, as the simulated device has it.

/// The plant under a sampled spring and damper.
class LinearLoop {
 public:
  LinearLoop(const SampledLoop& loop, double coulombFriction_N, double stiffness, double from_m,
             std::function<double(double, double)> length_m)
      : loop_(loop),
        stiffness_(stiffness),
        length_m_(std::move(length_m)),
        plant_(presetOf(loop, coulombFriction_N), HandPreset{}),
        delay_(static_cast<int>(std::lround(loop.delay_s / loop.period_s * kSubsteps))),
        forces_(static_cast<std::size_t>(delay_ / kSubsteps) + 2, 0.0),
        last_(from_m) {
    plant_.place({from_m, 0, 0});
  }

  void tick() {
    const double x = plant_.position().x;
    std::shift_right(forces_.begin(), forces_.end(), 1);
    forces_[0] = -stiffness_ * length_m_(x, stiffness_) - loop_.damping_Ns_per_m * (x - last_) / loop_.period_s;
    last_ = x;
    for (int i = 0; i < kSubsteps; ++i) {
      const int ago = std::max(0, (delay_ - i + kSubsteps - 1) / kSubsteps);
      plant_.step(loop_.period_s / kSubsteps, {forces_[static_cast<std::size_t>(ago)], 0, 0}, HandTarget{}, Vec3(0));
    }
  }
  /// Of an undamped oscillation, m.
  [[nodiscard]] double amplitude_m() const {
    return std::hypot(plant_.position().x, plant_.velocity().x / std::sqrt(stiffness_ / loop_.mass_kg));
  }

 private:
  static DevicePreset presetOf(const SampledLoop& loop, double coulombFriction_N) {
    DevicePreset preset{};
    preset.apparentMass_kg = loop.mass_kg;
    preset.viscousFriction_Ns_per_m = loop.viscousFriction_Ns_per_m;
    preset.coulombFriction_N = coulombFriction_N;
    return preset;
  }

  SampledLoop loop_;
  double stiffness_;
  std::function<double(double, double)> length_m_;
  Plant plant_;
  int delay_;
  std::vector<double> forces_;  // the newest first
  double last_;
};

/// Does a displacement grow, once the modes that die fast have died? Judged over many periods of the slowest mode.
bool dies(
    const SampledLoop& loop, double coulombFriction_N, double stiffness, double from_m,
    double softest_N_per_m = std::numeric_limits<double>::infinity(),
    const Stand& stand = [] { return [](double x, double) { return x; }; }) {
  constexpr double kCycles = 60;
  constexpr double kGone = 1e-3, kGrown = 3;
  LinearLoop simulated(loop, coulombFriction_N, stiffness, from_m, stand());
  const double cycle_s = 2 * std::numbers::pi * std::sqrt(loop.mass_kg / std::min(stiffness, softest_N_per_m));
  const auto ticks = static_cast<int>(kCycles * cycle_s / loop.period_s) + 200;
  double early = 0, late = 0;
  for (int i = 0; i < ticks; ++i) {
    simulated.tick();
    const double amplitude = simulated.amplitude_m();
    if (amplitude > kGrown * 10 * from_m) return false;
    if (coulombFriction_N > 0 && amplitude < kGone * from_m) return true;
    if (i >= ticks / 3 && i < 2 * ticks / 3) early = std::max(early, amplitude);
    if (i >= 2 * ticks / 3) late = std::max(late, amplitude);
  }
  return late <= early;
}

template <class Holds>
double largest(double from, double ratio, Holds holds, double most = std::numeric_limits<double>::infinity()) {
  constexpr double kClose = 1.002;
  double good = from;
  while (!holds(good)) good /= ratio;
  while (good * ratio <= most && holds(good * ratio)) good *= ratio;
  if (good * ratio > most) return most;
  double bad = good * ratio;
  while (bad / good > kClose) {
    const double middle = std::sqrt(good * bad);
    (holds(middle) ? good : bad) = middle;
  }
  return good;
}

Record compared(const SampledLoop& loop, std::string_view formula, double predicted, double simulated, double allowed) {
  const double off = simulated / predicted - 1;
  return {{"method", "simulated_plant"},
          {"scene", formula},
          {"mass_kg", loop.mass_kg},
          {"b_Ns_per_m", loop.viscousFriction_Ns_per_m},
          {"B_Ns_per_m", loop.damping_Ns_per_m},
          {"rate_Hz", 1 / loop.period_s},
          {"delay_ms", loop.delay_s * 1e3},
          {"predicted", predicted},
          {"simulated", simulated},
          {"difference_ratio", off},
          {"pass", std::abs(off) <= allowed}};
}

constexpr double kAllowed = 0.1;

void compareStiffness(const SampledLoop& loop, std::vector<Record>& records) {
  const double exact = exactLimit_N_per_m(loop);
  if (exact == 0) return;  // the damper alone is unstable
  const double simulated = simulatedLimit_N_per_m(loop);
  records.push_back(compared(loop, "exact_eigenvalues_N_per_m", exact, simulated, kAllowed));
  if (loop.damping_Ns_per_m == 0 && loop.delay_s == 0) {
    records.push_back(compared(loop, "colgate_2b_over_T_N_per_m", passiveLimit_N_per_m(loop), simulated, kAllowed));
  }
  constexpr double kMaxDamping = 2, kMaxDelay_s = 1.001e-3;
  if (loop.damping_Ns_per_m <= kMaxDamping && loop.delay_s <= kMaxDelay_s) {
    records.push_back(compared(loop, "gil_delay_formula_N_per_m", delayLimit_N_per_m(loop), simulated, kAllowed));
  }
}

void compareRadius(const SampledLoop& loop, double coulombFriction_N, double stiffness, std::vector<Record>& records) {
  constexpr double kAllowedRadius = 0.2;
  const double predicted = localRadius_m(loop, coulombFriction_N, stiffness);
  const double simulated = simulatedRadius_m(loop, coulombFriction_N, stiffness);
  Record record = compared(loop, "diolaiti_local_radius_m", predicted, simulated, kAllowedRadius);
  record["K_N_per_m"] = stiffness;
  record["f_c_N"] = coulombFriction_N;
  records.push_back(std::move(record));
}

}  // namespace

double simulatedLimit_N_per_m(const SampledLoop& loop) {
  constexpr double kRatio = 1.2;
  return largest(delayLimit_N_per_m(loop), kRatio, [&](double k) { return dies(loop, 0, k, 1e-3); });
}

double simulatedLimit_N_per_m(const SampledLoop& loop, const Stand& stand, double softest_N_per_m,
                              double most_N_per_m) {
  constexpr double kRatio = 1.2;
  return largest(
      delayLimit_N_per_m(loop), kRatio, [&](double k) { return dies(loop, 0, k, 1e-3, softest_N_per_m, stand); },
      most_N_per_m);
}

double simulatedRadius_m(const SampledLoop& loop, double coulombFriction_N, double stiffness_N_per_m) {
  constexpr double kRatio = 1.3;
  return largest(localRadius_m(loop, coulombFriction_N, stiffness_N_per_m), kRatio,
                 [&](double x) { return dies(loop, coulombFriction_N, stiffness_N_per_m, x); });
}

std::vector<Record> compareWithTheory() {
  std::vector<Record> records;
  for (const double mass : {0.075, 0.25}) {
    for (const double b : {0.05, 0.5}) {
      for (const double rate : {1e3, 4e3}) {
        for (const double delay_s : {0.0, 1e-3, 5e-3}) {
          for (const double damping : {0.0, 2.0, 5.0}) {
            compareStiffness({mass, b, damping, 1 / rate, delay_s}, records);
          }
        }
      }
    }
  }
  const SampledLoop loop{0.1, 0.2, 0, 1e-3, 0};
  compareRadius(loop, 0.04, 1000, records);
  compareRadius(loop, 0.2, 1000, records);
  compareRadius(loop, 0.04, 3000, records);
  compareRadius({0.25, 0.5, 0, 1e-3, 0}, 0.05, 3000, records);
  return records;
}

}  // namespace haptics::eval
