#include "haptic_server/device/device.h"

#include <cmath>

namespace haptics {

double gyration_m(const DeviceInfo& device) noexcept {
  const bool isKnown = device.apparentMass_kg > 0 && device.rotation.inertia_kgm2 > 0;
  return isKnown ? std::sqrt(device.rotation.inertia_kgm2 / device.apparentMass_kg) : kUsualGyration_m;
}

DeviceInfo rotationAsTranslation(const DeviceInfo& device) {
  const DeviceRotation& rotation = device.rotation;
  const double r = gyration_m(device);
  return {.name = device.name,
          .maxForce_N = rotation.maxTorque_Nm / r,
          .maxStiffness_N_per_m = rotation.maxTorsion_Nm_per_rad / (r * r),
          .maxDamping_Ns_per_m = 0,
          .resolution_m = rotation.resolution_rad * r,
          .apparentMass_kg = rotation.inertia_kgm2 / (r * r),
          .viscousFriction_Ns_per_m = rotation.viscousFriction_Nms_per_rad / (r * r),
          .coulombFriction_N = rotation.coulombFriction_Nm / r,
          .delay_s = device.delay_s};
}

}  // namespace haptics
