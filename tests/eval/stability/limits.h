#pragma once

namespace haptics::eval {

/// A sampled spring and damper on a device: what the formulas of the literature speak of. SI units.
struct SampledLoop {
  double mass_kg = 0;
  double viscousFriction_Ns_per_m = 0;
  double damping_Ns_per_m = 0;  ///< Rendered, on the backward difference.
  double period_s = 1e-3;
  double delay_s = 0;  ///< Beyond the hold; whole periods for exactLimit_N_per_m().
};

/// Largest K that is passive: b > K T / 2 + |B| (Colgate & Schenkel 1997). Negative where none is.
[[nodiscard]] double passiveLimit_N_per_m(const SampledLoop& loop) noexcept;

/// Largest K that is stable: K < (b + B) / (T / 2 + t_d) (Gil, Avello, Rubio & Florez 2004).
[[nodiscard]] double delayLimit_N_per_m(const SampledLoop& loop) noexcept;

/// Largest K with which every eigenvalue of the sampled system is within the unit circle.
[[nodiscard]] double exactLimit_N_per_m(const SampledLoop& loop);

/// Largest K that is passive with Coulomb friction and an encoder: min(2 b / T, 2 f_c / step) (Abbott & Okamura 2005).
[[nodiscard]] double frictionLimit_N_per_m(double viscousFriction_Ns_per_m, double coulombFriction_N, double step_m,
                                           double period_s) noexcept;

/// Amplitude (m) within which an oscillation dies out though the loop is unstable without Coulomb friction (Diolaiti
/// et al. 2006; by the describing function): 4 f_c / (pi w (K T / 2 - b)), w = sqrt(K / m).
[[nodiscard]] double localRadius_m(const SampledLoop& loop, double coulombFriction_N,
                                   double stiffness_N_per_m) noexcept;

}  // namespace haptics::eval
