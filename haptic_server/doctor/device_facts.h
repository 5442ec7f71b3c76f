#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "haptic_server/doctor/findings.h"

namespace haptics {

/// What devices that people own need of this machine, as far as it has them.
struct DeviceFacts {
  struct OnUsb {
    std::string title;  ///< Of its maker's device.
    bool mayOpen = false;
    bool staysAwake = false;  ///< power/control is not "auto".
  };
  std::vector<OnUsb> onUsb;

  // Touch:
  std::string openHaptics;             ///< File of its library; empty: none.
  std::string gtddHome;                ///< As the environment says it.
  bool isPaired = false;               ///< There is something in it.
  std::vector<std::string> closedTty;  ///< ttyACM nodes that may not be opened.

  std::string forceDimension;  ///< File of its library; empty: none.
  std::string fdsdk;           ///< As the environment says it.

  bool haplyListens = false;  ///< Something does at the service's port, 10001.
  bool haplyIsHere = false;   ///< The service or the Hub is installed.
};

using Environment = std::map<std::string, std::string>;
/// Of this process: the variables that makers' libraries are found by.
[[nodiscard]] Environment deviceEnvironment();

/// Reads them from the folders below `root`.
[[nodiscard]] DeviceFacts readDeviceFacts(const Environment& environment, const std::filesystem::path& root = "/");

/// Nothing of a maker of whom nothing is here.
[[nodiscard]] std::vector<Finding> judge(const DeviceFacts& facts);

}  // namespace haptics
