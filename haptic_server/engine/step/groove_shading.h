#pragma once

#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

/// Force shading (paper 4.1) where surfaces of several bodies hold the IHIP: it is put where their smooth surfaces meet.
/// Deviation from the paper, where one object is touched: each surface is taken to be its tangent plane at the IHIP, twice.
/// Not of a body of which several surfaces hold the IHIP, which has no N_s there.
/// @param[in,out] ihip  On the polygons, as dents have them; world, m.
/// @param work  Of the tick. Once its allowance is spent, the polygons are felt.
/// @return Whether a body has an N_s. Its normals are then those of state.groove.
[[nodiscard]] bool shadeGroove(const ServoScene& scene, HapticState& state, Vec3& ihip, ContactWork& work) noexcept;

}  // namespace haptics
