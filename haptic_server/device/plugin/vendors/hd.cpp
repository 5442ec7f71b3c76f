#include "haptic_server/device/plugin/vendors/hd.h"

#include <array>
#include <cstdio>

#include "haptic_server/device/plugin/vendors/vendor_library.h"

namespace haptics {
namespace {

// Where the loader looks, and LD_LIBRARY_PATH says.
const std::array<std::string, 3> kNames{"libHD.so", "libHD.so.3.4", "libHD.so.3.0"};

struct Loaded {
  VendorLibrary library{kNames};
  Hd functions{};

  Loaded() {
    const auto find = [this](const char* name, auto& function) { library.find(name, function); };
    find("hdInitDevice", functions.hdInitDevice);
    find("hdDisableDevice", functions.hdDisableDevice);
    find("hdMakeCurrentDevice", functions.hdMakeCurrentDevice);
    find("hdEnable", functions.hdEnable);
    find("hdGetString", functions.hdGetString);
    find("hdScheduleAsynchronous", functions.hdScheduleAsynchronous);
    find("hdUnschedule", functions.hdUnschedule);
    find("hdSetSchedulerRate", functions.hdSetSchedulerRate);
    find("hdStartScheduler", functions.hdStartScheduler);
    find("hdStopScheduler", functions.hdStopScheduler);
    find("hdBeginFrame", functions.hdBeginFrame);
    find("hdEndFrame", functions.hdEndFrame);
    find("hdGetDoublev", functions.hdGetDoublev);
    find("hdGetIntegerv", functions.hdGetIntegerv);
    find("hdSetDoublev", functions.hdSetDoublev);
    find("hdGetError", functions.hdGetError);
    find("hdCheckCalibration", functions.hdCheckCalibration);
    find("hdUpdateCalibration", functions.hdUpdateCalibration);
  }
};

}  // namespace

const Hd* Hd::load(std::string& reason) {
  static const Loaded loaded;
  if (loaded.library) return &loaded.functions;
  reason = "OpenHaptics: " + loaded.library.reason();
  return nullptr;
}

std::string Hd::inWords(unsigned error) {
  switch (error) {
    case 0x200:
      return "its motors are warm";
    case 0x201:
      return "more than its largest force was asked for";
    case 0x202:
      return "its force changed too fast";
    case 0x203:
      return "it was moved too fast";
    case 0x204:
      return "a force error";
    case 0x300:
      return "device fault";
    case 0x301:
      return "it is opened already";
    case 0x302:
      return "communication error: cable, power, pairing, or no permission to open it";
    case 0x303:
      return "communication is not configured: pair it by its maker's setup, and let GTDD_HOME name the folder";
    case 0x304:
      return "timer error";
    case 0x400:
    case 0x401:
    case 0x402:
      return "a frame out of turn";
    case 0x600:
      return "no licence";
    default:
      char text[32];
      std::snprintf(text, sizeof text, "error 0x%X", error);
      return text;
  }
}

}  // namespace haptics
