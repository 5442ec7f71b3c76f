#include "haptic_server/doctor/device_facts.h"

#include <glob.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

namespace haptics {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kTouch = "3D Systems Touch", kForceDimension = "Force Dimension";
struct Known {
  std::string_view vendor, product, title;
};
constexpr std::array kKnown{Known{"1451", "0402", kForceDimension}, Known{"2988", "0302", kTouch},
                            Known{"0301", "2988", kTouch}, Known{"0403", "cb48", "Novint Falcon"},
                            Known{"1234", "0006", "WoodenHaptics"}};
constexpr std::string_view kHaplyPort = ":2711 ", kListening = " 0A ";  // of /proc/net/tcp: 10001

[[nodiscard]] std::string wordIn(const fs::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
}

[[nodiscard]] std::string valueOf(const Environment& environment, const std::string& name) {
  const auto found = environment.find(name);
  return found == environment.end() ? "" : found->second;
}

/// The first file that matches; "" for none.
[[nodiscard]] std::string firstOf(const fs::path& root, const std::vector<std::string>& patterns) {
  for (const std::string& pattern : patterns) {
    glob_t found{};
    const std::string below = (root / fs::path(pattern).relative_path()).string();
    const bool any = ::glob(below.c_str(), 0, nullptr, &found) == 0;
    const std::string file = any ? found.gl_pathv[0] : "";
    ::globfree(&found);
    if (any) return file;
  }
  return "";
}

/// Where the loader looks for a library.
[[nodiscard]] std::vector<std::string> loaderPatterns(const Environment& environment, const std::string& name) {
  std::vector<std::string> patterns;
  std::istringstream folders(valueOf(environment, "LD_LIBRARY_PATH"));
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty()) patterns.push_back(folder + "/" + name);
  }
  for (const char* const folder :
       {"/usr/local/lib/", "/usr/lib/", "/usr/lib64/", "/usr/lib/*-linux-gnu/", "/lib/*-linux-gnu/"})
    patterns.push_back(folder + name);
  return patterns;
}

[[nodiscard]] std::vector<std::string> forceDimensionPatterns(const Environment& environment, const std::string& name) {
  std::vector<std::string> patterns;
  if (const std::string sdk = valueOf(environment, "FDSDK"); !sdk.empty())
    patterns.push_back(sdk + "/lib/release/lin-*-gcc/" + name);
  if (const std::string home = valueOf(environment, "HOME"); !home.empty())
    patterns.push_back(home + "/.local/lib/" + name);
  for (const char* const folder : {"/usr/local/lib/", "/usr/lib/", "/usr/lib/*-linux-gnu/"})
    patterns.push_back(folder + name);
  return patterns;
}

[[nodiscard]] std::vector<DeviceFacts::OnUsb> onUsb(const fs::path& root) {
  std::vector<DeviceFacts::OnUsb> devices;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(root / "sys/bus/usb/devices", ignored)) {
    const std::string vendor = wordIn(entry.path() / "idVendor"), product = wordIn(entry.path() / "idProduct");
    const auto known =
        std::ranges::find_if(kKnown, [&](const Known& one) { return one.vendor == vendor && one.product == product; });
    if (known == kKnown.end()) continue;
    const auto padded = [&](const char* file) {
      const std::string number = wordIn(entry.path() / file);
      return std::string(3 - std::min<std::size_t>(3, number.size()), '0') + number;
    };
    const fs::path node = root / "dev/bus/usb" / padded("busnum") / padded("devnum");
    devices.push_back({.title = std::string(known->title),
                       .mayOpen = ::access(node.c_str(), R_OK | W_OK) == 0,
                       .staysAwake = wordIn(entry.path() / "power/control") != "auto"});
  }
  std::ranges::sort(devices, {}, &DeviceFacts::OnUsb::title);
  return devices;
}

[[nodiscard]] bool haplyListens(const fs::path& root) {
  for (const char* const file : {"proc/net/tcp", "proc/net/tcp6"}) {
    std::ifstream in(root / file);
    for (std::string line; std::getline(in, line);) {
      const std::size_t local = line.find(kHaplyPort);  // the first of the two addresses: its state follows the second
      const std::size_t listening = line.find(kListening);
      if (local != std::string::npos && listening != std::string::npos && local < listening) return true;
    }
  }
  return false;
}

[[nodiscard]] bool has(const DeviceFacts& facts, std::string_view title) {
  return std::ranges::find(facts.onUsb, title, &DeviceFacts::OnUsb::title) != facts.onUsb.end();
}

void judgeUsb(const DeviceFacts& facts, std::vector<Finding>& findings) {
  for (const auto& device : facts.onUsb) {
    // A Touch is opened by its ttyACM node.
    if (!device.mayOpen && device.title != kTouch) {
      findings.push_back({device.title, "on USB, and may not be opened", Verdict::kWorse,
                          "copy deploy/udev/70-haptic-devices.rules to /etc/udev/rules.d, run \"udevadm control "
                          "--reload\", and plug it in again"});
    } else if (!device.staysAwake) {
      findings.push_back(
          {device.title, "on USB, and put to sleep when it rests (power/control is auto)", Verdict::kWorse,
           "write \"on\" into its power/control below /sys/bus/usb/devices; the udev rules in deploy/udev "
           "do, for those that they know"});
    } else {
      findings.push_back({device.title, "on USB, may be opened, stays awake"});
    }
  }
}

void judgeTouch(const DeviceFacts& facts, std::vector<Finding>& findings) {
  if (!has(facts, kTouch) && facts.openHaptics.empty() && facts.gtddHome.empty()) return;
  if (facts.openHaptics.empty()) {
    findings.push_back({"OpenHaptics", "no libHD.so where the loader looks", Verdict::kWorse,
                        "install the maker's driver and OpenHaptics; LD_LIBRARY_PATH names a folder elsewhere"});
  } else {
    findings.push_back({"OpenHaptics", facts.openHaptics});
  }
  if (facts.gtddHome.empty()) {
    findings.push_back({"GTDD_HOME", "is not set", Verdict::kWorse,
                        "the maker's driver keeps the pairing there: export GTDD_HOME=/usr/share/3DSystems, or the "
                        "folder that its setup names"});
  } else if (!facts.isPaired) {
    findings.push_back({"GTDD_HOME", facts.gtddHome + " is no folder with files in it that may be read",
                        Verdict::kWorse, "pair the device by its maker's setup, as the user who runs the server"});
  } else {
    findings.push_back(
        {"GTDD_HOME", facts.gtddHome + " has files; whether the device is paired, its maker's setup says"});
  }
  for (const std::string& node : facts.closedTty) {
    findings.push_back({"Touch on USB", node + " may not be opened", Verdict::kWorse,
                        "a Touch is such a node: sudo adduser $USER dialout, and log in again"});
  }
}

}  // namespace

Environment deviceEnvironment() {
  Environment environment;
  for (const char* const name : {"GTDD_HOME", "FDSDK", "HOME", "LD_LIBRARY_PATH"}) {
    if (const char* const value = std::getenv(name)) environment[name] = value;
  }
  return environment;
}

DeviceFacts readDeviceFacts(const Environment& environment, const fs::path& root) {
  DeviceFacts facts;
  facts.onUsb = onUsb(root);
  facts.openHaptics = firstOf(root, loaderPatterns(environment, "libHD.so*"));
  facts.gtddHome = valueOf(environment, "GTDD_HOME");
  std::error_code ignored;
  if (!facts.gtddHome.empty()) {
    const fs::directory_iterator files(root / fs::path(facts.gtddHome).relative_path(), ignored);
    facts.isPaired = !ignored && files != fs::directory_iterator();
  }
  for (const auto& entry : fs::directory_iterator(root / "dev", ignored)) {
    if (entry.path().filename().string().starts_with("ttyACM") && ::access(entry.path().c_str(), R_OK | W_OK) != 0)
      facts.closedTty.push_back("/dev/" + entry.path().filename().string());
  }
  std::ranges::sort(facts.closedTty);
  facts.fdsdk = valueOf(environment, "FDSDK");
  for (const char* const name : {"libdrd.so*", "libdhd.so*"}) {
    if (facts.forceDimension.empty()) facts.forceDimension = firstOf(root, forceDimensionPatterns(environment, name));
  }
  facts.haplyListens = haplyListens(root);
  facts.haplyIsHere = !firstOf(root, {"/etc/systemd/system/haply*", "/lib/systemd/system/haply*",
                                      "/usr/lib/systemd/system/haply*", "/opt/*aply*"})
                           .empty();
  return facts;
}

std::vector<Finding> judge(const DeviceFacts& facts) {
  std::vector<Finding> findings;
  judgeUsb(facts, findings);
  judgeTouch(facts, findings);
  if (has(facts, kForceDimension) || !facts.fdsdk.empty() || !facts.forceDimension.empty()) {
    if (facts.forceDimension.empty()) {
      findings.push_back(
          {"Force Dimension SDK",
           facts.fdsdk.empty() ? "no libdrd.so" : "no libdrd.so below FDSDK, " + facts.fdsdk + ", nor elsewhere",
           Verdict::kWorse, "install the maker's SDK, and let FDSDK name its folder"});
    } else {
      findings.push_back({"Force Dimension SDK", facts.forceDimension});
    }
  }
  if (facts.haplyListens) {
    findings.push_back({"Haply's service", "something listens at port 10001"});
  } else if (facts.haplyIsHere) {
    findings.push_back({"Haply's service", "installed, and nothing listens at port 10001", Verdict::kWorse,
                        "start it, and plug the Inverse3 in: systemctl start haply-inverse-service"});
  }
  return findings;
}

}  // namespace haptics
