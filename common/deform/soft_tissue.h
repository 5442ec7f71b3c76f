#pragma once

#include <algorithm>

#include "common/deform/dent.h"
#include "common/deform/falloff.h"
#include "common/maths/elementary.h"

namespace haptics {

/// How a soft object yields.
///
/// The contact's spring, k_c, and the tissue's, k_t, are in series: of a penetration p below the surface at rest, the
/// tissue takes w* = p k_c / (k_c + k_t), and what is felt is as stiff as (1 / k_c + 1 / k_t)^-1. A viscous tissue
/// (Kelvin-Voigt) goes back by exp(-t / returnTime) when released, and under the stylus towards w* faster, by the same
/// dashpot: k_c (p - w) = k_t (w + returnTime w').
///
/// Of a plastic tissue a part of the deepest w stays: under a stylus that draws back, w does not go below that, so that the
/// contact's spring alone unloads, as metal and clay do; and it is the shape at rest for the next contact.
struct SoftTissue {
  Falloff falloff;
  double stiffness_N_per_m;  ///< k_t, > 0.
  double returnTime_s;       ///< 0: elastic.
  double plastic = 0;        ///< The part that stays, 0 to 1.

  /// Of a plastic tissue what goes back, and what is left behind by a contact that moves on, takes this long at least
  /// (seconds): shorter is seen as a jump, longer lets a quick hand meet a dent that is still coming.
  static constexpr double kMinReturn_s = 0.03;

  bool operator==(const SoftTissue&) const = default;

  /// The part of an untouched dent that is left after a time.
  [[nodiscard]] double leftAfter(double time_s) const noexcept {
    const double return_s = plastic > 0 ? std::max(returnTime_s, kMinReturn_s) : returnTime_s;
    return return_s > 0 ? elementary::exp(-time_s / return_s) : 0;
  }

  /// The share of a lasting penetration that the tissue takes, 0 to 1.
  /// @param factor  Of k_t, where it varies over the surface.
  [[nodiscard]] double share(double contact_N_per_m, double factor = 1) const noexcept {
    return contact_N_per_m / (contact_N_per_m + factor * stiffness_N_per_m);
  }

  /// How far the tissue has yielded (metres) a time after `yielded_m`, under a penetration of the surface at rest. Exact
  /// for a penetration that stays, whatever the time: no step is too long for it.
  [[nodiscard]] double yield_m(double yielded_m, double penetration_m, double contact_N_per_m, double time_s,
                               double factor = 1) const noexcept {
    const double share = this->share(contact_N_per_m, factor);
    const double goal = share * penetration_m;
    if (!(returnTime_s > 0)) return goal;
    const double touched_s = returnTime_s * (1 - share);
    return goal + (yielded_m - goal) * elementary::exp(-time_s / touched_s);
  }
};

}  // namespace haptics
