#pragma once

#include "haptic_server/engine/step/soft_contact.h"

namespace haptics {

/// Bodies that hold the IHIP together, some of them soft, yield together.
/// @param obstruction  Of the one body that holds the IHIP, what its dent comes upon in another; or nothing.
/// @param[in,out] tick  The contact found with the shapes at rest; then as it is on the dented ones, or none.
void deformTogether(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick,
                    const Obstruction& obstruction) noexcept;

}  // namespace haptics
