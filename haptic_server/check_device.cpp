#include "haptic_server/check_device.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/command_line/command_line.h"
#include "common/text/printable.h"
#include "haptic_server/attached_device.h"
#include "haptic_server/bring_up/device_check.h"
#include "haptic_server/doctor/findings.h"
#include "haptic_server/servo/realtime.h"

namespace haptics {
namespace {

constexpr double kMaxPush_N = 2;
/// Exit status of the process that checks: this and what check() says. Another one is that of a driver that ended it.
constexpr int kCheckEnded = 100;

void sleepFor(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

class RealTime final : public CheckTime {
 public:
  [[nodiscard]] std::uint64_t now_ns() override { return monotonicNow_ns(); }
  void sleepUntil(std::uint64_t time_ns) override {
    if (const std::uint64_t now_ns = monotonicNow_ns(); now_ns < time_ns)
      std::this_thread::sleep_for(std::chrono::nanoseconds(time_ns - now_ns));
  }
  [[nodiscard]] bool pauseProcess(double seconds) override {
    if (pausing_ > 0) ::waitpid(pausing_, nullptr, 0);
    const pid_t self = ::getpid();
    pausing_ = ::fork();
    if (pausing_ != 0) return pausing_ > 0;
    sleepFor(0.005);  // forking has held it up
    ::kill(self, SIGSTOP);
    sleepFor(seconds);
    ::kill(self, SIGCONT);
    ::_exit(0);
  }

 private:
  pid_t pausing_ = 0;  ///< The newest that did.
};

/// What is said, on the terminal and in the report.
class Said {
 public:
  [[nodiscard]] bool keepIn(const std::string& file) {
    if (file.empty()) return true;
    report_.open(file);
    return report_.good();
  }
  void operator()(const std::string& line) {
    std::cout << line << std::endl;
    onlyInReport(line);
  }
  void onlyInReport(const std::string& line) {
    if (report_.is_open()) report_ << line << std::endl;
  }
  [[nodiscard]] bool good() const { return report_.good(); }

 private:
  std::ofstream report_;
};

/// A folder's name may be a person's.
[[nodiscard]] std::string withoutFolders(const std::string& device) {
  return device.substr(0, device.find(':') + 1) +
         std::filesystem::path(device.substr(device.find(':') + 1)).filename().string();
}

void describeMachine(Said& said) {
  said.onlyInReport("The machine:");
  for (const Finding& finding : judge(readMachineFacts()))
    said.onlyInReport((finding.verdict == Verdict::kGood ? "ok    " : "-     ") + finding.what + ": " + finding.found);
}

[[nodiscard]] bool waitForEnter(const std::string& prompt) {
  std::cout << prompt << ", then press Enter: " << std::flush;
  std::string text;
  return static_cast<bool>(std::getline(std::cin, text));
}

/// From its end on the process has a few seconds left: a call of a driver may never return.
class LastSeconds {
 public:
  LastSeconds() = default;
  ~LastSeconds() {
    std::thread([] {
      constexpr double kForTheDriver_s = 3;
      sleepFor(kForTheDriver_s);
      std::cerr << "check-device: a call of the driver does not return; it is not waited for" << std::endl;
      std::_Exit(kCheckEnded + 1);
    }).detach();
  }
  LastSeconds(const LastSeconds&) = delete;
  LastSeconds& operator=(const LastSeconds&) = delete;
};

struct CheckOptions {
  ServerOptions server;
  double seconds = 5, force_N = 0;
  std::string report;
};

[[nodiscard]] int check(const CheckOptions& options) {
  Said said;
  if (!said.keepIn(options.report)) {
    std::cerr << "check-device: --report " << printable(options.report) << ": cannot be written\n";
    return 1;
  }
  auto attached = AttachedDevice::attach(options.server);
  if (!attached) {
    std::cerr << "check-device: " << printable(attached.error().text()) << '\n';
    return 1;
  }
  const LastSeconds ending;  // goes before the device, whose driver it waits for
  Device& device = (*attached)->device();
  char text[128];
  std::snprintf(text, sizeof text, "%s: at most %g N", printable(device.info().name).c_str(), device.info().maxForce_N);
  said.onlyInReport("check-device " + printable(withoutFolders(options.server.device)));
  said(text);
  (*attached)->start();
  RealtimeStatus status;
  configureServoThread(std::nullopt, status);
  RealTime time;
  DeviceCheck check(device, time, options.server.rate_Hz.value_or(kDefaultRate_Hz), std::ref(said));
  if (!check.waitUntilReady()) return 1;
  std::snprintf(text, sizeof text, "Reading for %g s; move it, let it rest, and press its buttons.", options.seconds);
  said(text);
  check.readPositions(options.seconds);
  if (options.force_N > 0) {
    if (!waitForEnter("Hold the handle lightly in the middle of its workspace")) return 1;
    std::snprintf(text, sizeof text, "Pushing with %g N, while somebody holds it.", options.force_N);
    said.onlyInReport(text);
    check.judgeForces(std::min(options.force_N, device.info().maxForce_N));
  }
  check.judgeAxes();
  device.stop();
  said(check.good() ? "All is well." : "Not all is well.");
  describeMachine(said);
  if (!options.report.empty() && !said.good()) {
    std::cerr << "check-device: --report " << printable(options.report) << ": not all of it could be written\n";
    return 1;
  }
  return check.good() ? 0 : 1;
}

/// In a process of its own: the shell that waits for this one is not to see it stand still.
[[nodiscard]] int checkApart(const CheckOptions& options) {
  const pid_t self = ::getpid(), child = ::fork();
  if (child < 0) return check(options);
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int code = ::getppid() == self ? check(options) : 1;
    std::cout.flush();
    std::exit(kCheckEnded + code);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) >= kCheckEnded) return WEXITSTATUS(status) - kCheckEnded;
  if (WIFEXITED(status)) {
    std::cerr << "check-device: the driver ended it, with the status " << WEXITSTATUS(status) << '\n';
  } else {
    std::cerr << "check-device: ended by signal " << WTERMSIG(status) << '\n';
  }
  return 1;
}

}  // namespace

int runCheckDevice(int argc, char** argv) {
  CommandLine app{
      "Brings a force-feedback device up and says how often, how late, how finely and how quietly it tells its "
      "position; "
      "with --force, which way its forces push, how late, how stiff a spring it bears, and how soon its forces end, "
      "also when "
      "this program stands still."};
  CheckOptions options;
  app.option("device", options.server.device,
             "As for --device: falcon[:WHICH], wooden[:WHICH], forcedimension[:WHICH], haply[:WHICH], "
             "openhaptics[:WHICH], plugin:FILE[:WHICH]")
      .required()
      .check(
          [](const std::string& name) -> Result<void> {
            if (!isDeviceName(name)) return refused("", "there is no device \"" + name + "\"");
            return {};
          },
          "DEVICE");
  app.option("--seconds", options.seconds, "For how long positions are read").range(0.1, 3600.).showDefault();
  app.option("--force", options.force_N,
             "Push with so many newtons, up to 2, along each axis; somebody has to hold the handle")
      .range(0., kMaxPush_N);
  app.option("--report", options.report,
             "Also write all that is found, and what the machine permits, into this file: to send to others")
      .typeName("FILE");
  app.option("--rate", options.server.rate_Hz, "Hz of reads and writes").range(100., 20'000.);
  app.option("--calibration", options.server.calibration, "As for the server");
  app.option("--firmware", options.server.firmware, "As for the server");
  app.footer(
      "Examples:\n  haptic_server check-device falcon --firmware falcon.bin\n"
      "  haptic_server check-device plugin:./libmy_device.so --force 0.5 --report my_device.txt");
  if (const auto code = app.parse(argc, argv)) return *code;
  return checkApart(options);
}

}  // namespace haptics
