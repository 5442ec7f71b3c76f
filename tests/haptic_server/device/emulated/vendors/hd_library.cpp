// OpenHaptics' HD library as its reference has it, over an emulated arm, which has mm and N in the vendor's frame: a scheduler's thread
// calls one callback a millisecond, a state is read and a force set in a frame only, and errors wait until they are asked for.
#include <time.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "common/clock/monotonic.h"
#include "tests/haptic_server/device/emulated/vendors/shared_arm.h"

namespace {

using haptics::EmulatedArm;

constexpr unsigned kInvalidOperation = 0x102, kVelocity = 0x203, kCommunication = 0x302, kDeviceFault = 0x300,
                   kFrame = 0x402;
constexpr double kJump_mm = 50;

std::atomic<bool> runs{false};
std::thread scheduler;
unsigned (*callback)(void*) = nullptr;
void* callbackData = nullptr;
bool inFrame = false;
thread_local unsigned error = 0;
double wanted[3];

EmulatedArm& arm() {
  static EmulatedArm own{};
  static EmulatedArm* const shared = std::getenv("EMULATED_ARM") ? haptics::mapArm(std::getenv("EMULATED_ARM")) : &own;
  return *shared;
}

void raise(unsigned code) {
  if (error == 0) error = code;
}

void pause(std::uint64_t us) {
  const timespec time{0, static_cast<long>(us) * 1000};
  ::nanosleep(&time, nullptr);
}

void schedule() {
  while (runs) {
    pause(std::max<std::uint64_t>(1'000, arm().blocks_us));
    if (callback(callbackData) == 0) return;
  }
}

}  // namespace

extern "C" {

struct HDErrorInfo {
  unsigned errorCode;
  int internalErrorCode;
  unsigned device;
};

void* emulatedArm() { return &arm(); }

unsigned hdInitDevice(const char* name) {
  // As a driver of 2022: the default one only.
  if (name != nullptr || arm().unplugged) {
    raise(kCommunication);
    return 0xFFFFFFFF;
  }
  if (arm().inUse) {
    raise(0x301);
    return 0xFFFFFFFF;
  }
  ++arm().opens;
  return 0;
}
void hdDisableDevice(unsigned) { arm().forceOn = 0; }
void hdMakeCurrentDevice(unsigned) {}
void hdEnable(unsigned what) {
  if (what == 0x4000) arm().forceOn = 1;
}
const char* hdGetString(unsigned what) { return what == 0x2501 ? "Touch" : ""; }
unsigned long hdScheduleAsynchronous(unsigned (*function)(void*), void* data, unsigned short) {
  callback = function;
  callbackData = data;
  return 1;
}
void hdUnschedule(unsigned long) {}
void hdSetSchedulerRate(unsigned long) {}
void hdStartScheduler() {
  runs = true;
  scheduler = std::thread(schedule);
}
void hdStopScheduler() {
  runs = false;
  if (scheduler.joinable()) scheduler.join();
}
void hdBeginFrame(unsigned) {
  inFrame = true;
  if (arm().communication) raise(kCommunication);
  if (arm().unplugged) raise(kDeviceFault);
  if (arm().timeGuard) raise(kFrame);
  if (arm().saturated) raise(0x200);
  if (arm().forceOffCause != 0) raise(kVelocity);
}
void hdEndFrame(unsigned) {
  inFrame = false;
  for (std::size_t i = 0; i < 3; ++i) arm().force[i] = wanted[i];
  arm().written_ns = haptics::monotonicNow_ns();
  ++arm().writes;
}
void hdGetDoublev(unsigned what, double* values) {
  if (what == 0x2603) {
    *values = 3.3;
    return;
  }
  if (!inFrame) return raise(kFrame);
  if (what == 0x2050) {
    for (std::size_t i = 0; i < 3; ++i) values[i] = arm().position[i];
    if (arm().notFinite) values[1] = std::numeric_limits<double>::quiet_NaN();
    if (arm().jumped) values[0] += kJump_mm;
  } else if (what == 0x2051) {
    for (std::size_t i = 0; i < 3; ++i) values[i] = arm().velocity[i];
  } else if (what == 0x2052) {
    for (int i = 0; i < 16; ++i) {
      const int row = i % 4, column = i / 4;
      values[i] = row < 3 && column < 3 ? arm().rotation[static_cast<std::size_t>(3 * row + column)].load()
                  : i == 15             ? 1
                                        : 0;
    }
  } else {
    raise(kInvalidOperation);
  }
}
void hdGetIntegerv(unsigned what, int* values) {
  if (what == 0x2555) {
    *values = 4;
  } else if (!inFrame) {
    raise(kFrame);
  } else {
    *values = static_cast<int>(arm().buttons.load());
  }
}
void hdSetDoublev(unsigned what, const double* values) {
  if (!inFrame || what != 0x2700) return raise(kFrame);
  for (int i = 0; i < 3; ++i) wanted[i] = values[i];
}
HDErrorInfo hdGetError() {
  const HDErrorInfo newest{error, 0, 0};
  error = 0;
  return newest;
}
unsigned hdCheckCalibration() { return arm().lost ? 0x5002 : arm().initialised ? 0x5000 : 0x5001; }
void hdUpdateCalibration(unsigned style) {
  if (style == 4) arm().initialised = 1;
}
}
