#pragma once

namespace haptics {

/// How a device turns about the point at which it is held: alike about all axes.
struct DeviceRotation {
  bool isSensed = false;
  double maxTorque_Nm = 0;  ///< The magnitude limit uses it; 0: it gives no torque.
  double maxTorsion_Nm_per_rad = 0;
  double resolution_rad = 0;
  /// Dynamics of the device alone; an inertia of 0 when they are not known.
  double inertia_kgm2 = 0, viscousFriction_Nms_per_rad = 0, coulombFriction_Nm = 0;
};

inline constexpr double kUsualGyration_m = 0.05;

/// What the fingers open and close.
struct DeviceGripper {
  double range_rad = 0;     ///< How far it opens; 0: it has none, or that is not known.
  double maxMoment_Nm = 0;  ///< The magnitude limit uses it; 0: it gives no moment.
  double maxStiffness_Nm_per_rad = 0;
};

}  // namespace haptics
