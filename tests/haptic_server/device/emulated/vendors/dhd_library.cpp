// Force Dimension's library as its reference has it, over an emulated arm. A call without a device, or of one that is broken,
// returns -1 and leaves its number for dhdErrorGetLast().
#include <time.h>

#include <cmath>
#include <limits>

#include "common/clock/monotonic.h"
#include "tests/haptic_server/device/emulated/vendors/shared_arm.h"

namespace {

using haptics::EmulatedArm;

constexpr int kCommunication = 2, kNoDevice = 5, kNotAvailable = 6, kExpertOnly = 9, kInUse = 20;
constexpr int kTimeGuard = 1, kSaturated = 2;
constexpr double kJump_m = 0.05;

thread_local int lastError = 0;
bool expert = false;

EmulatedArm& arm() {
  static EmulatedArm own{};
  static EmulatedArm* const shared = std::getenv("EMULATED_ARM") ? haptics::mapArm(std::getenv("EMULATED_ARM")) : &own;
  return *shared;
}

int fail(int error) {
  lastError = error;
  return -1;
}

/// 0, or -1 where a call fails.
int call() {
  if (const std::uint32_t us = arm().blocks_us) {
    const timespec pause{0, static_cast<long>(us) * 1000};
    ::nanosleep(&pause, nullptr);
  }
  if (arm().unplugged) return fail(kNoDevice);
  if (arm().communication) return fail(kCommunication);
  return 0;
}

int position(double* x, double* y, double* z) {
  if (call() < 0) return -1;
  *x = arm().notFinite ? std::numeric_limits<double>::quiet_NaN() : arm().position[0] + (arm().jumped ? kJump_m : 0);
  *y = arm().position[1];
  *z = arm().position[2];
  return arm().timeGuard ? kTimeGuard : 0;
}

}  // namespace

extern "C" {

void* emulatedArm() { return &arm(); }

int dhdErrorGetLast() { return lastError; }
const char* dhdErrorGetLastStr() {
  return lastError == kCommunication  ? "communication error"
         : lastError == kNoDevice     ? "no device found"
         : lastError == kNotAvailable ? "feature not available"
         : lastError == kExpertOnly   ? "expert mode disabled"
         : lastError == kInUse        ? "device already in use"
                                      : "no error";
}
int drdOpenID(char id) {
  if (call() < 0) return -1;
  if (id > 0) return fail(kNoDevice);
  if (arm().inUse) return fail(kInUse);
  ++arm().opens;
  return 0;
}
int drdClose(char) {
  arm().forceOn = 0;
  arm().watchdog_ns = 0;
  return 0;
}
bool drdIsInitialized(char) { return arm().initialised && !arm().lost; }
int drdAutoInit(char) {
  ++arm().movesByItself;
  arm().initialised = 1;
  return call();
}
int drdStop(bool, char) { return call(); }
int dhdGetSystemType(char) { return static_cast<int>(arm().type.load()); }
const char* dhdGetSystemName(char) { return arm().type == 104 ? "sigma.7" : arm().type == 34 ? "omega.6" : "omega.3"; }
bool dhdHasWrist(char) { return arm().hasWrist; }
bool dhdHasActiveWrist(char) { return arm().hasActiveWrist; }
bool dhdHasGripper(char) { return arm().hasGripper; }
int dhdEnableExpertMode() {
  expert = true;
  return 0;
}
int dhdDisableExpertMode() {
  expert = false;
  return 0;
}
int dhdSetWatchdog(unsigned char periods, char) {
  if (!expert) return fail(kExpertOnly);
  arm().watchdog_ns = std::uint64_t{125'000} * periods;
  return call();
}
int dhdEnableForce(unsigned char on, char) {
  if (call() < 0) return -1;
  arm().written_ns = haptics::monotonicNow_ns();
  arm().forceOffCause = on ? 0 : 4;
  arm().forceOn = on;
  return 0;
}
int dhdGetStatus(int* status, char) {
  if (call() < 0) return -1;
  for (int i = 0; i < 17; ++i) status[i] = 0;
  status[0] = status[1] = status[2] = 1;
  status[5] = arm().forceOn ? 1 : 0;
  status[12] = arm().hasWrist ? 1 : 0;
  status[14] = static_cast<int>(arm().forceOffCause.load());
  return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char) { return position(x, y, z); }
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double frame[3][3], char) {
  for (int i = 0; i < 9; ++i) frame[i / 3][i % 3] = arm().rotation[static_cast<std::size_t>(i)];
  return position(x, y, z);
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char) {
  *x = arm().velocity[0];
  *y = arm().velocity[1];
  *z = arm().velocity[2];
  return call();
}
int dhdGetGripperAngleRad(double* angle, char) {
  *angle = arm().gripper_rad;
  return call();
}
unsigned dhdGetButtonMask(char) { return arm().buttons; }
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double grip,
                                        char) {
  if (call() < 0) return -1;
  const double wrench[6]{fx, fy, fz, tx, ty, tz};
  for (std::size_t i = 0; i < 3; ++i) {
    arm().force[i] = wrench[i];
    arm().torque[i] = wrench[3 + i];
  }
  arm().gripperForce = grip;
  arm().written_ns = haptics::monotonicNow_ns();
  ++arm().writes;
  return arm().saturated ? kSaturated : 0;
}
}
