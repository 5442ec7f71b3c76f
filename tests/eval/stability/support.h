#pragma once

#include <memory>
#include <vector>

#include "haptic_server/engine/motion/rigid_body.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "tests/eval/report.h"
#include "tests/eval/stability/limits.h"

namespace haptics::eval {

/// What a sampled spring stands on, where that is no wall: a body on a slider with a spring of its own, or tissue.
struct Support {
  double mass_kg = 0;            ///< Of the body; 0: tissue.
  double stiffness_N_per_m = 0;  ///< Between body and world; of the tissue.
  double damping_Ns_per_m = 0;   ///< Between body and world.
  double returnTime_s = 0;       ///< Of the tissue; 0: elastic.
};

/// Of the loops that are measured with devices, and compared with theory.
[[nodiscard]] Support bodySupport() noexcept;
[[nodiscard]] Support viscousSupport() noexcept;
[[nodiscard]] Support elasticSupport() noexcept;

/// As the step has it: along an axis of the object's frame, without gravity.
[[nodiscard]] RigidBody bodyOf(const Support& support, Vec3 axis) noexcept;
/// With a falloff of this radius.
[[nodiscard]] SoftTissue tissueOf(const Support& support, double radius_m) noexcept;

/// Largest K (N/m), up to kStiffest_N_per_m, with which every eigenvalue of the sampled system is within the unit circle;
/// without rendered damping. 0 where none is.
[[nodiscard]] double exactLimit_N_per_m(const SampledLoop& loop, const Support& support);
inline constexpr double kStiffest_N_per_m = 1e6;

/// The production code of body and tissue under the simulated plant, against those eigenvalues.
[[nodiscard]] std::vector<Record> compareFootings();

}  // namespace haptics::eval
