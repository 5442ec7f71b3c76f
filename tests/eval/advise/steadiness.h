#pragma once

#include "haptic_server/device/presets.h"
#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// How a simulated device rests on an object after it was pushed onto it with 1 N, in virtual time on the production
/// step with the server's stabiliser.
struct Steadiness {
  double cycle_um = 0;   ///< Of the penetration, peak to peak, in the last 0.3 s of 2 s.
  bool touching = true;  ///< Throughout that time.
  bool steady = false;   ///< Touching, and no more than two position quanta or 20 um.
};

/// @param place  On the surface, world, metres; `normal` its outward unit normal, against which is pushed.
/// @param hand  "none" pushes with 1 N and has neither mass nor spring; others hold their spring's end where it gives
/// 1 N.
[[nodiscard]] Steadiness restOn(const ServoScene& scene, Vec3 place, Vec3 normal, const DevicePreset& device,
                                const HandPreset& hand, double rate_Hz);

}  // namespace haptics::eval
