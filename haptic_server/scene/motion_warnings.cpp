#include "haptic_server/scene/motion_warnings.h"

#include <algorithm>
#include <sstream>

#include "haptic_server/motion/coupling.h"
#include "haptic_server/scene/derived_parts.h"

namespace haptics {

std::vector<std::string> motionWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                        const DeviceLimits& device) {
  const auto body = rigidBodyAndMassOf(record, assets);
  if (!body || !*body) return {};
  const double mass_kg = (*body)->apparentMass_kg;
  const double stiffness = std::min(record.material.stiffness_N_per_m, device.stiffest_N_per_m);
  const double damping = std::min(record.material.damping_Ns_per_m, device.maxDamping_Ns_per_m);
  const double share = stableStiffnessShare(mass_kg, stiffness, damping, device.period_s);
  if (share >= 1) return {};
  std::ostringstream text;
  text.precision(4);
  text << "warning: stiffness and damping are felt as " << share * stiffness << " N/m and " << share * damping
       << " N s/m instead of " << stiffness << " and " << damping
       << ": pushed where it gives most, this body weighs no more than " << 1e3 * mass_kg << " g, and at "
       << 1 / device.period_s << " Hz it would be thrown about; from " << record.motion->mass_kg / share
       << " kg on, or at a higher rate, it bears them";
  return {text.str()};
}

}  // namespace haptics
