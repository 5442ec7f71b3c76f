#include "haptic_server/check_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/command_line/command_line.h"
#include "common/telemetry/fault_words.h"
#include "common/text/printable.h"
#include "haptic_server/attached_device.h"

namespace haptics {
namespace {

constexpr double kReadyWithin_s = 30, kRamp_s = 0.2, kHold_s = 0.3, kBetween_s = 0.5, kMaxPush_N = 2;
/// What the servo asks of a position: older ones are not felt through.
constexpr double kOldest_us = 5'000;
constexpr double kStopWithin_s = 0.03;
constexpr double kMoved_m = 5e-4;
constexpr std::array kAxes{"x", "y", "z"};

/// Reads the device once a period, as the servo does.
class Ticks {
 public:
  Ticks(Device& device, double rate_Hz)
      : device_(device), period_ns_(static_cast<std::uint64_t>(1e9 / rate_Hz)), next_ns_(monotonicNow_ns()) {}

  DeviceReading next(Vec3 force_N) {
    next_ns_ += period_ns_;
    if (const std::uint64_t now_ns = monotonicNow_ns(); now_ns < next_ns_)
      std::this_thread::sleep_for(std::chrono::nanoseconds(next_ns_ - now_ns));
    fresh_ = device_.hasNewSample();
    const DeviceReading reading = device_.read(tick_++);
    device_.write(force_N);
    if (fresh_) {
      low_ = glm::min(low_, reading.position);
      high_ = glm::max(high_, reading.position);
    }
    return reading;
  }
  [[nodiscard]] bool everChanged(int axis) const noexcept { return high_[axis] > low_[axis]; }
  [[nodiscard]] bool fresh() const noexcept { return fresh_; }  ///< The last reading had a new position.
  [[nodiscard]] double period_s() const noexcept { return static_cast<double>(period_ns_) * 1e-9; }

 private:
  Device& device_;
  std::uint64_t period_ns_, next_ns_, tick_ = 0;
  bool fresh_ = false;
  Vec3 low_{1e9}, high_{-1e9};
};

struct Spread {
  double middle = 0, high = 0, largest = 0;  // 50th and 99th percentile
};

[[nodiscard]] Spread spreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  return {at(0.5), at(0.99), values.back()};
}

/// How often the value of an axis changes, in positions: a new position may carry an old value.
class AxisValues {
 public:
  void add(double value) {
    ++held_;
    if (const double moved_m = std::abs(value - last_); any_ && moved_m > kSame_m) {
      smallest_m_ = smallest_m_ == 0 ? moved_m : std::min(smallest_m_, moved_m);
      changes_.push_back({moved_m, held_});
      held_ = 0;
    } else if (!any_) {
      held_ = 0;
    }
    any_ = true;
    last_ = value;
  }
  [[nodiscard]] double smallestStep_m() const noexcept { return smallest_m_; }
  /// Positions from one value to the next at the median, while it moves: a hand that is slow crosses a step of the encoder
  /// now and then, one that is fast several at once. 0: it was not moved enough to tell.
  [[nodiscard]] double positionsPerValue(double resolution_m) const {
    std::vector<double> held;
    for (const Change& change : changes_) {
      if (change.moved_m >= kSteps * std::max(resolution_m, smallest_m_)) held.push_back(change.held);
    }
    return held.size() < kEnough ? 0 : spreadOf(std::move(held)).middle;
  }

 private:
  struct Change {
    double moved_m;
    int held;
  };
  static constexpr double kSame_m = 1e-12, kSteps = 4;
  static constexpr std::size_t kEnough = 10;
  std::vector<Change> changes_;
  double last_ = 0, smallest_m_ = 0;
  int held_ = 0;
  bool any_ = false;
};

class Check {
 public:
  Check(Device& device, double rate_Hz) : device_(device), ticks_(device, rate_Hz), rate_Hz_(rate_Hz) {}

  [[nodiscard]] bool waitUntilReady() {
    DeviceReading reading;
    for (double waited_s = 0; waited_s < kReadyWithin_s; waited_s += ticks_.period_s()) {
      reading = ticks_.next(Vec3(0));
      if (reading.state == DeviceState::kReady) return true;
    }
    return report(false, std::string("within 30 s it is not ready: ") + inWords(reading.status.fault));
  }

  void readPositions(double seconds) {
    std::vector<double> gaps_ms, ages_us;
    std::array<AxisValues, 3> axes;
    Vec3 low(1e9), high(-1e9);
    double sinceFresh_s = 0;
    unsigned buttons = 0, faults = 0;
    const int count = static_cast<int>(seconds * rate_Hz_);
    for (int i = 0; i < count; ++i) {
      const DeviceReading reading = ticks_.next(Vec3(0));
      for (int k = 0; ticks_.fresh() && k < 3; ++k) axes[static_cast<std::size_t>(k)].add(reading.position[k]);
      if (reading.state != DeviceState::kReady) {
        if (++faults == 1) std::cout << "  fault: " << inWords(reading.status.fault) << '\n';
        continue;
      }
      buttons |= reading.status.buttons;
      ages_us.push_back(reading.status.age_us);
      sinceFresh_s += ticks_.period_s();
      if (!ticks_.fresh()) continue;
      gaps_ms.push_back(1e3 * sinceFresh_s);
      sinceFresh_s = 0;
      low = glm::min(low, reading.position);
      high = glm::max(high, reading.position);
    }
    const Spread gap = spreadOf(gaps_ms), age = spreadOf(ages_us);
    line("new positions", "%.0f a second, of %.0f ticks", static_cast<double>(gaps_ms.size()) / seconds, rate_Hz_);
    line("between them", "%.1f ms, 99 %% %.1f ms, at most %.1f ms", gap.middle, gap.high, gap.largest);
    line("age when read", "%.0f us, 99 %% %.0f us, at most %.0f us", age.middle, age.high, age.largest);
    line("smallest step", "%.1f, %.1f, %.1f um (x, y, z); it says %.1f um", 1e6 * axes[0].smallestStep_m(),
         1e6 * axes[1].smallestStep_m(), 1e6 * axes[2].smallestStep_m(), 1e6 * device_.info().resolution_m);
    const Vec3 range = gaps_ms.empty() ? Vec3(0) : high - low;
    line("moved within", "%.2f, %.2f, %.2f mm", 1e3 * range.x, 1e3 * range.y, 1e3 * range.z);
    std::cout << "  buttons seen    ";
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((buttons >> bit & 1U) != 0) std::cout << bit << ' ';
    }
    std::cout << (buttons == 0 ? "none\n" : "\n");
    report(faults == 0, "no fault in " + std::to_string(count) + " ticks");
    report(!gaps_ms.empty() && age.high <= kOldest_us, "positions are fresh enough to be felt through (5 ms)");
    for (std::size_t k = 0; k < 3; ++k) {
      const double positions = axes[k].positionsPerValue(device_.info().resolution_m);
      if (positions >= 2) {
        char finding[128];
        std::snprintf(finding, sizeof finding, "%s has a new value only with every %.0fth position while it moves",
                      kAxes[k], positions);
        report(false, finding);
      }
    }
  }

  /// An encoder that stands still says nothing wrong of itself.
  void judgeAxes() {
    for (int k = 0; k < 3; ++k) {
      if (!ticks_.everChanged(k)) {
        report(false, std::string(kAxes[static_cast<std::size_t>(k)]) +
                          " never changed: move the handle along it; if you did, it is not measured");
      }
    }
  }

  /// Pushes along each axis and looks where the hand goes.
  void push(double force_N) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 along(0);
      along[axis] = force_N;
      const Vec3 from = restAt();
      const Vec3 to = pushFor(along);
      const double moved_m = (to - from)[axis];
      const std::string name = std::string("+") + kAxes[static_cast<std::size_t>(axis)];
      line(("pushed along " + name).c_str(), "%+.2f mm", 1e3 * moved_m);
      report(moved_m > kMoved_m, moved_m < -kMoved_m ? name + " pushes the other way: reversed_axes, or turn_rad"
                                 : moved_m > kMoved_m
                                     ? name + " pushes the right way"
                                     : name + " does not move the hand: held too tightly, or there is no force");
      for (double t = 0; t < kBetween_s; t += ticks_.period_s()) (void)ticks_.next(Vec3(0));
    }
  }

  /// Lets go in the middle of a push, and looks how soon the hand comes back.
  void stop(double force_N) {
    const Vec3 along(0, 0, force_N);
    (void)restAt();
    const Vec3 pushed = pushFor(along);
    device_.stop();
    double back_s = 0;
    for (double t = 0; t < kHold_s && back_s == 0; t += ticks_.period_s()) {
      // A stopped device does not hear the force.
      if (ticks_.next(along).position.z < pushed.z - kMoved_m / 5) back_s = t;
    }
    if (back_s == 0) {
      report(false, "the hand does not come back after stop: let it go, or the force stays");
      return;
    }
    line("after stop", "it is on its way back within %.0f ms", 1e3 * back_s);
    report(back_s <= kStopWithin_s, "the force ends within 30 ms");
  }

  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  Device& device_;
  Ticks ticks_;
  double rate_Hz_;
  bool good_ = true;

  template <class... Values>
  static void line(const char* label, const char* format, Values... values) {
    std::printf("  %-16s", label);
    std::printf(format, values...);
    std::printf("\n");
    std::fflush(stdout);
  }
  bool report(bool isGood, const std::string& finding) {
    std::cout << (isGood ? "ok    " : "BAD   ") << finding << std::endl;
    good_ = good_ && isGood;
    return isGood;
  }
  /// The mean position of some ticks.
  [[nodiscard]] Vec3 restAt() {
    constexpr int kMean = 100;
    Vec3 sum(0);
    for (int i = 0; i < kMean; ++i) sum += ticks_.next(Vec3(0)).position;
    return sum / double{kMean};
  }
  [[nodiscard]] Vec3 pushFor(Vec3 force_N) {
    Vec3 at(0);
    for (double t = 0; t < kRamp_s + kHold_s; t += ticks_.period_s()) {
      at = ticks_.next(std::min(1.0, t / kRamp_s) * force_N).position;
    }
    return at;
  }
};

[[nodiscard]] bool waitForEnter(const std::string& prompt) {
  std::cout << prompt << ", then press Enter: " << std::flush;
  std::string text;
  return static_cast<bool>(std::getline(std::cin, text));
}

}  // namespace

int runCheckDevice(int argc, char** argv) {
  CommandLine app{
      "Brings a force-feedback device up and says how often, how late and how finely it tells its position; with "
      "--force, which way its forces push and how soon they end."};
  ServerOptions options;
  double seconds = 5, force_N = 0;
  app.option("device", options.device,
             "As for --device: falcon[:WHICH], wooden[:WHICH], forcedimension[:WHICH], haply[:WHICH], "
             "openhaptics[:WHICH], plugin:FILE[:WHICH]")
      .required()
      .check(
          [](const std::string& name) -> Result<void> {
            if (!isDeviceName(name)) return refused("", "there is no device \"" + name + "\"");
            return {};
          },
          "DEVICE");
  app.option("--seconds", seconds, "For how long positions are read").range(0.1, 3600.).showDefault();
  app.option("--force", force_N, "Push with so many newtons, up to 2, along each axis; somebody has to hold the handle")
      .range(0., kMaxPush_N);
  app.option("--rate", options.rate_Hz, "Hz of reads and writes").range(100., 20'000.);
  app.option("--calibration", options.calibration, "As for the server");
  app.option("--firmware", options.firmware, "As for the server");
  app.footer(
      "Examples:\n  haptic_server check-device falcon --firmware falcon.bin\n"
      "  haptic_server check-device plugin:./libmy_device.so --force 0.5");
  if (const auto code = app.parse(argc, argv)) return *code;

  auto attached = AttachedDevice::attach(options);
  if (!attached) {
    std::cerr << "check-device: " << printable(attached.error().text()) << '\n';
    return 1;
  }
  Device& device = (*attached)->device();
  const DeviceInfo& info = device.info();
  std::cout << printable(info.name) << ": at most " << info.maxForce_N << " N\n";
  (*attached)->start();
  Check check(device, options.rate_Hz.value_or(kDefaultRate_Hz));
  if (!check.waitUntilReady()) return 1;
  std::cout << "Reading for " << seconds << " s; move it, and press its buttons.\n";
  check.readPositions(seconds);
  if (force_N > 0) {
    if (!waitForEnter("Hold the handle lightly in the middle of its workspace")) return 1;
    check.push(std::min(force_N, info.maxForce_N));
    check.stop(std::min(force_N, info.maxForce_N));
  }
  check.judgeAxes();
  device.stop();
  std::cout << (check.good() ? "All is well.\n" : "Not all is well.\n");
  return check.good() ? 0 : 1;
}

}  // namespace haptics
