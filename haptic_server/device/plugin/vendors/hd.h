#pragma once

#include <string>

namespace haptics {

/// What is used of OpenHaptics' HD API, 3.0 to 3.4; names and numbers are theirs. mm, N. A state is read and a force set in a frame only,
/// in the thread of its scheduler.
struct Hd {
  struct ErrorInfo {
    unsigned errorCode;
    int internalErrorCode;
    unsigned device;
  };
  static constexpr unsigned kInvalidHandle = 0xFFFFFFFF;
  static constexpr unsigned kButtons = 0x2000, kPosition = 0x2050, kVelocity = 0x2051, kTransform = 0x2052,
                            kModel = 0x2501;
  static constexpr unsigned kCalibrationStyles = 0x2555, kMaxForce = 0x2603, kForce = 0x2700, kForceOutput = 0x4000;
  static constexpr unsigned kCalibrated = 0x5000, kNeedsUpdate = 0x5001;
  static constexpr unsigned kWarmMotors = 0x200, kExceededForce = 0x201, kForceError = 0x204;  ///< And those between.
  static constexpr unsigned kContinue = 1, kDone = 0;                                          ///< Of a callback.
  static constexpr unsigned short kDefaultPriority = 0x7FFF;
  using Callback = unsigned(void*);

  unsigned (*hdInitDevice)(const char* name);
  void (*hdDisableDevice)(unsigned device);
  void (*hdMakeCurrentDevice)(unsigned device);
  void (*hdEnable)(unsigned what);
  const char* (*hdGetString)(unsigned what);
  unsigned long (*hdScheduleAsynchronous)(Callback* callback, void* data, unsigned short priority);
  void (*hdUnschedule)(unsigned long handle);
  void (*hdSetSchedulerRate)(unsigned long rate_Hz);
  void (*hdStartScheduler)();
  void (*hdStopScheduler)();
  void (*hdBeginFrame)(unsigned device);
  void (*hdEndFrame)(unsigned device);
  void (*hdGetDoublev)(unsigned what, double* values);
  void (*hdGetIntegerv)(unsigned what, int* values);
  void (*hdSetDoublev)(unsigned what, const double* values);
  ErrorInfo (*hdGetError)();
  unsigned (*hdCheckCalibration)();
  void (*hdUpdateCalibration)(unsigned style);

  /// Loads them once; null, and `reason` says why, where they are not all there. The library stays loaded: it fails when it is
  /// loaded twice.
  [[nodiscard]] static const Hd* load(std::string& reason);
  /// Of an error's number: "motors that are warm".
  [[nodiscard]] static std::string inWords(unsigned error);
};

}  // namespace haptics
