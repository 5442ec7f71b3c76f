#pragma once

#include "tests/eval/accuracy_run.h"

namespace haptics::eval {

/// A method in the servo's loop, at 1 kHz and without delay, between the default device in nobody's hand and a mesh:
/// where the stabiliser that the server runs has the HIP, what the method answers is the spring's force. So it is what
/// contact costs that differs, for every method has the same stabiliser.
struct ClosedLoopRest {
  double limitCycle_um =
      0;  ///< HIP, peak to peak along the worst axis, in the last 0.3 s of 2 s; of the worst place. Metres where
          ///< the device is thrown off.
  double allowed_um = 0;  ///< Of the device: max(2 encoder steps, 20 um).

  [[nodiscard]] bool steady() const { return limitCycle_um <= allowed_um * (1 + 1e-6); }
};

/// Under a push of 1 N against what the method answers at several places of the shape's path, with kSpring_N_per_m.
[[nodiscard]] ClosedLoopRest restOnMesh(const Method& method, const Sample& sample);

/// Largest stiffness (N/m), from kSpring_N_per_m to 200 kN/m, up to which every one that was tried comes to rest at the
/// first of these places in every way of pressing (stability/critical.h); 0 when the least does not. Softer ones are
/// left out: the HIP is so deep under them that what it meets is another side of the body. In steps of a tenth, and the
/// least of several heights between two encoder steps: where one is worth a newton, rest is a matter of chance. Takes
/// some tenths of a second.
[[nodiscard]] double criticalOnMesh_N_per_m(const Method& method, const Sample& sample);

}  // namespace haptics::eval
