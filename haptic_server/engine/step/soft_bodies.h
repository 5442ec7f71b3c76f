#pragma once

#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// Soft objects yield to the contact (paper 5 (d)), and dents that nothing presses go back. The dent of the contact goes
/// along with it; released, it stays where it is. What is plastic of it stays for good, and marks are left along its way, a
/// dent's width from each other, which make a groove: those are the shape at rest for the contacts after it, and the
/// builder bakes them into the surface (ServoObject::baked).
///
/// The contact core finds the contact with the shape at rest; what the tissue takes of that penetration follows from it in
/// the same tick, by springs in series (SoftTissue), and the IHIP is then looked for on the dented triangles. So however
/// far the surface moves in a tick, the contact is not lost for it: the shape in which it is found does not move.
/// Deviation from displacing the surface after the contact, with the force of the tick before: that feels like a damper of
/// k_c T against a hand that presses, and loses the contact of one that draws back.
///
/// Bodies that hold the IHIP together yield together, each in series with its own tissue. A dent ends where its centre
/// meets another body: the IHIP on a soft body is inside of no other.
/// @param[in,out] tick  Its contact was found with the shapes at rest; then it is as on the dented ones, or none where a
/// dent that is still going back leaves the HIP outside. Its spring force gets what tissue that varies over the surface
/// pushes along it (varying_springs.h).
void deformAtContact(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick) noexcept;

/// The dents for the tick just made.
/// @param[in,out] motion  As of an earlier tick.
/// @return Whether anything differs from that.
[[nodiscard]] bool updateDentsState(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept;

}  // namespace haptics
