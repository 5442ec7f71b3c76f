#pragma once

#include <array>
#include <string>

namespace haptics {

/// What is used of Force Dimension's DHD and DRD 3.17, which libdrd has both of; names and numbers are theirs. m, N, N m, rad;
/// below 0 is an error. `id` is the device's number, -1 the only one.
struct Dhd {
  static constexpr int kTimeGuard = 1;       ///< Nothing new since the last call.
  static constexpr int kMotorSaturated = 2;  ///< The force is less than was asked for.
  static constexpr int kNoDeviceFound = 5;   ///< Of dhdErrorGetLast().
  static constexpr int kStatusCount = 17;
  /// Places of dhdGetStatus().
  static constexpr std::size_t kReset = 3, kForce = 5, kWristInitialised = 12, kForceOffCause = 14;
  enum class ForceOff : int { kNone, kButton, kVelocity, kWatchdog, kSoftware, kUsb, kDeadMan };
  using Frame = double[3][3];

  int (*drdOpenID)(char id);
  int (*drdClose)(char id);
  bool (*drdIsInitialized)(char id);
  int (*drdAutoInit)(char id);
  int (*drdStop)(bool forceOn, char id);
  int (*dhdErrorGetLast)();
  const char* (*dhdErrorGetLastStr)();
  int (*dhdGetSystemType)(char id);
  const char* (*dhdGetSystemName)(char id);
  bool (*dhdHasWrist)(char id);
  bool (*dhdHasActiveWrist)(char id);
  bool (*dhdHasGripper)(char id);
  int (*dhdEnableExpertMode)();
  int (*dhdDisableExpertMode)();
  int (*dhdSetWatchdog)(unsigned char periods_125us, char id);
  int (*dhdEnableForce)(unsigned char on, char id);
  int (*dhdGetStatus)(int* status, char id);
  int (*dhdGetPosition)(double* x, double* y, double* z, char id);
  int (*dhdGetPositionAndOrientationFrame)(double* x, double* y, double* z, Frame frame, char id);
  int (*dhdGetLinearVelocity)(double* vx, double* vy, double* vz, char id);
  int (*dhdGetGripperAngleRad)(double* angle, char id);
  unsigned (*dhdGetButtonMask)(char id);
  int (*dhdSetForceAndTorqueAndGripperForce)(double fx, double fy, double fz, double tx, double ty, double tz,
                                             double grip, char id);

  /// Loads them once; null, and `reason` says why, where they are not all there.
  [[nodiscard]] static const Dhd* load(std::string& reason);
};

}  // namespace haptics
