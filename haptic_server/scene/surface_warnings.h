#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/object_assets.h"

namespace haptics {

/// Mean length of its edges, over some thousand triangles.
[[nodiscard]] double meanEdge_m(const TriMesh& mesh);
[[nodiscard]] std::string millimetres(double length_m);

/// What a device, and the servo that drives it, make of objects.
struct DeviceLimits {
  double encoderStep_m = 0;  ///< 0: not known.
  /// Textures and friction are kept below this lateral stiffness (StepConfig).
  double stableLateral_N_per_m = std::numeric_limits<double>::infinity();
  double period_s = 1e-3;  ///< Of the servo.
  /// Surfaces that are stiffer are felt with this: half of what the device bears.
  double stiffest_N_per_m = std::numeric_limits<double>::infinity();
  double maxDamping_Ns_per_m = std::numeric_limits<double>::infinity();         ///< The same of damping,
  double stiffestTorsion_Nm_per_rad = std::numeric_limits<double>::infinity();  ///< and of what turns a tool.
  double stiffestGrip_Nm_per_rad = std::numeric_limits<double>::infinity();     ///< and of what opens its jaws.
  int hands = 1;                                                                ///< That may push a body at once.
  bool observed =
      true;  ///< The step has an observer (StepConfig), by which springs from both sides are as stable as walls.
};

/// Warnings of a texture, or a map of friction, stiffness or softness, whose finest detail is finer than two steps of the device's encoder, which feel it
/// as something else, or than two edges of the mesh, which show it so; of pits that Eq. (4a) makes bumps; and of a
/// stiffness at its stiffest place, what such a map pushes sideways, a damping or a texture's steepness that is clamped for the device to stay stable;
/// and of a stiffness by which single steps of the encoder are felt.
[[nodiscard]] std::vector<std::string> surfaceWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                       const DeviceLimits& device);

/// A warning of a body that is so light that its surface is felt softer than asked for: stableStiffnessShare().
[[nodiscard]] std::vector<std::string> motionWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                      const DeviceLimits& device);

}  // namespace haptics
