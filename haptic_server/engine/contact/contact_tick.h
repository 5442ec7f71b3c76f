#pragma once

#include <span>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/corrections.h"

namespace haptics {

/// followContact() by the steps of section 1.4 of README.md, whatever they cost. Into a `result` as constructed, but
/// for its allowance.
void followGuarded(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   const Corrections& corrections = kAllCorrections) noexcept;

}  // namespace haptics
