#include "haptic_server/device/plugin/vendors/dhd.h"

#include <cstdlib>
#include <vector>

#include "haptic_server/device/plugin/vendors/vendor_library.h"

namespace haptics {
namespace {

/// Where the maker's package and those who install by hand put it.
[[nodiscard]] std::vector<std::string> patternsOf(const std::string& name) {
  std::vector<std::string> patterns;
  if (const char* const sdk = std::getenv("FDSDK"))
    patterns.push_back(std::string(sdk) + "/lib/release/lin-*-gcc/" + name + ".so*");
  if (const char* const home = std::getenv("HOME"))
    patterns.push_back(std::string(home) + "/.local/lib/" + name + ".so*");
  for (const char* const folder : {"/usr/local/lib/", "/usr/lib/", "/usr/lib/*-linux-gnu/"})
    patterns.push_back(folder + name + ".so*");
  return patterns;
}

struct Loaded {
  VendorLibrary library{patternsOf("libdrd"), patternsOf("libdhd")};
  Dhd functions{};

  Loaded() {
    const auto find = [this](const char* name, auto& function) { library.find(name, function); };
    find("drdOpenID", functions.drdOpenID);
    find("drdClose", functions.drdClose);
    find("drdIsInitialized", functions.drdIsInitialized);
    find("drdAutoInit", functions.drdAutoInit);
    find("drdStop", functions.drdStop);
    find("dhdErrorGetLast", functions.dhdErrorGetLast);
    find("dhdErrorGetLastStr", functions.dhdErrorGetLastStr);
    find("dhdGetSystemType", functions.dhdGetSystemType);
    find("dhdGetSystemName", functions.dhdGetSystemName);
    find("dhdHasWrist", functions.dhdHasWrist);
    find("dhdHasActiveWrist", functions.dhdHasActiveWrist);
    find("dhdHasGripper", functions.dhdHasGripper);
    find("dhdEnableExpertMode", functions.dhdEnableExpertMode);
    find("dhdDisableExpertMode", functions.dhdDisableExpertMode);
    find("dhdSetWatchdog", functions.dhdSetWatchdog);
    find("dhdEnableForce", functions.dhdEnableForce);
    find("dhdGetStatus", functions.dhdGetStatus);
    find("dhdGetPosition", functions.dhdGetPosition);
    find("dhdGetPositionAndOrientationFrame", functions.dhdGetPositionAndOrientationFrame);
    find("dhdGetLinearVelocity", functions.dhdGetLinearVelocity);
    find("dhdGetGripperAngleRad", functions.dhdGetGripperAngleRad);
    find("dhdGetButtonMask", functions.dhdGetButtonMask);
    find("dhdSetForceAndTorqueAndGripperForce", functions.dhdSetForceAndTorqueAndGripperForce);
  }
};

}  // namespace

const Dhd* Dhd::load(std::string& reason) {
  static const Loaded loaded;
  if (loaded.library) return &loaded.functions;
  reason = "Force Dimension's library: " + loaded.library.reason() + ". Install its SDK, and let FDSDK name its folder";
  return nullptr;
}

}  // namespace haptics
