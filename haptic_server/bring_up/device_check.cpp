#include "haptic_server/bring_up/device_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <utility>

#include "common/telemetry/fault_words.h"

namespace haptics {
namespace {

constexpr double kReadyWithin_s = 30, kRamp_s = 0.2, kHold_s = 0.3, kBetween_s = 0.5;
/// What the servo asks of a position: older ones are not felt through.
constexpr double kOldest_us = 5'000;
constexpr double kStopWithin_s = 0.03;
constexpr double kMoved_m = 5e-4, kResting_m = 1e-3;
/// Noise that damping and friction make felt; where the steps of the encoder are larger than half of that, they are.
constexpr double kNoise_m = 3e-5;
constexpr int kTaps = 5;
constexpr double kTap_s = 0.08;
/// Beyond it hard surfaces shake, where the device does not say its delay.
constexpr double kLongestDelay_s = 0.01;
/// A device takes its force away 25 ms after the last one was written (device_plugin.h); the rest is what the measurement is sure to.
constexpr double kWatchdog_s = 0.05;
constexpr std::array kPauses_s{0.015, 0.03, 0.05, 0.08, 0.15, 0.3};
constexpr double kMinStiffness_N_per_m = 100, kMaxStiffness_N_per_m = 5'000, kStiffnessStep = 1.4;
constexpr std::array kAxes{"x", "y", "z"};

[[nodiscard]] std::string nameOf(int axis) { return kAxes[static_cast<std::size_t>(axis)]; }

/// Does it swing to and fro at 8 Hz or more, by a force that counts?
[[nodiscard]] bool shakes(const std::vector<double>& positions_m, double seconds, double stiffness_N_per_m,
                          double force_N) {
  double mean_m = 0, variance = 0;
  for (const double p : positions_m) mean_m += p / static_cast<double>(positions_m.size());
  int crossings = 0;
  for (std::size_t i = 0; i < positions_m.size(); ++i) {
    const double off = positions_m[i] - mean_m;
    variance += off * off / static_cast<double>(positions_m.size());
    crossings += i > 0 && off * (positions_m[i - 1] - mean_m) < 0 ? 1 : 0;
  }
  return crossings / 2.0 / seconds >= 8 && stiffness_N_per_m * std::sqrt(variance) > 0.4 * force_N;
}

}  // namespace

DeviceCheck::DeviceCheck(Device& device, CheckTime& time, double rate_Hz, std::function<void(const std::string&)> say)
    : device_(device),
      time_(time),
      period_s_(1 / rate_Hz),
      next_ns_(time.now_ns()),
      say_(std::move(say)),
      quality_(device.info().resolution_m) {}

template <class Force>
DeviceReading DeviceCheck::tickBy(Force forceOf) {
  next_ns_ += static_cast<std::uint64_t>(period_s_ * 1e9);
  if (time_.now_ns() < next_ns_) {
    time_.sleepUntil(next_ns_);
  } else {
    next_ns_ = time_.now_ns();  // no burst to catch up
  }
  fresh_ = device_.hasNewSample();
  const DeviceReading reading = device_.read(tick_++);
  device_.write(forceOf(reading));
  measured_ns_ = time_.now_ns() - std::min(time_.now_ns(), std::uint64_t{1'000} * reading.status.age_us);
  if (fresh_) quality_.add(reading.position, measured_ns_);  // also those that the driver does not believe
  return reading;
}

DeviceReading DeviceCheck::tick(Vec3 force_N) {
  return tickBy([&](const DeviceReading&) { return force_N; });
}

bool DeviceCheck::waitUntilReady() {
  DeviceReading reading;
  for (double waited_s = 0; waited_s < kReadyWithin_s; waited_s += period_s_) {
    reading = tick(Vec3(0));
    if (reading.state == DeviceState::kReady) {
      quality_ = PositionQuality(device_.info().resolution_m);  // coordinates jump at homing
      return true;
    }
  }
  return report(false, std::string("within 30 s it is not ready: ") + inWords(reading.status.fault));
}

void DeviceCheck::readPositions(double seconds) {
  std::vector<double> gaps_ms, apart_ms, ages_us;
  double sinceFresh_s = 0;
  std::uint64_t last_ns = 0;
  unsigned buttons = 0, faults = 0;
  const int count = static_cast<int>(seconds / period_s_);
  for (int i = 0; i < count; ++i) {
    const DeviceReading reading = tick(Vec3(0));
    if (reading.state != DeviceState::kReady) {
      if (++faults == 1) line("fault", "%s", inWords(reading.status.fault));
      continue;
    }
    buttons |= reading.status.buttons;
    ages_us.push_back(reading.status.age_us);
    sinceFresh_s += period_s_;
    if (!fresh_) continue;
    if (last_ns != 0) apart_ms.push_back(1e-6 * static_cast<double>(measured_ns_ - std::min(last_ns, measured_ns_)));
    last_ns = measured_ns_;
    gaps_ms.push_back(1e3 * sinceFresh_s);
    sinceFresh_s = 0;
  }
  const auto all = [](const std::vector<double>& values, double share) { return percentile(values, share); };
  const double oldest_us = all(ages_us, 0.99);
  line("new positions", "%.0f a second, of %.0f ticks", static_cast<double>(gaps_ms.size()) / seconds, 1 / period_s_);
  line("between them", "%.1f ms, 99 %% %.1f ms, at most %.1f ms", all(gaps_ms, 0.5), all(gaps_ms, 0.99),
       all(gaps_ms, 1));
  line("age when read", "%.0f us, 99 %% %.0f us, at most %.0f us", all(ages_us, 0.5), oldest_us, all(ages_us, 1));
  line("smallest step", "%.1f, %.1f, %.1f um (x, y, z); it says %.1f um", 1e6 * quality_.smallestStep_m(0),
       1e6 * quality_.smallestStep_m(1), 1e6 * quality_.smallestStep_m(2), 1e6 * device_.info().resolution_m);
  line("noise at rest", "%.1f, %.1f, %.1f um", 1e6 * quality_.noise_m(0), 1e6 * quality_.noise_m(1),
       1e6 * quality_.noise_m(2));
  const Vec3 range = quality_.range_m();
  line("moved within", "%.2f, %.2f, %.2f mm", 1e3 * range.x, 1e3 * range.y, 1e3 * range.z);
  std::string seen;
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((buttons >> bit & 1U) != 0) seen += std::to_string(bit) + ' ';
  }
  line("buttons seen", "%s", seen.empty() ? "none" : seen.c_str());

  report(faults == 0, faults == 0 ? "no fault in " + std::to_string(count) + " ticks"
                                  : "a fault in " + std::to_string(faults) + " of " + std::to_string(count) + " ticks");
  report(!gaps_ms.empty() && oldest_us <= kOldest_us, "positions are fresh enough to be felt through (5 ms)");
  // Whoever reads them may be held up, and miss some: a device that is too slow has none that are near each other.
  if (const double near_ms = all(apart_ms, 0.1); near_ms >= 1.5e3 * period_s_) {
    char finding[128];
    std::snprintf(finding, sizeof finding, "new positions are %.1f ms apart, and should be %.1f ms", near_ms,
                  1e3 * period_s_);
    report(false, finding);
  }
  bool valuesChange = true;
  for (int k = 0; k < 3; ++k) {
    const double positions = quality_.positionsPerValue(k);
    if (positions >= 2) {
      valuesChange = false;
      report(false, nameOf(k) + " has a new value only with every " + std::to_string(std::lround(positions)) +
                        "th position while it moves");
    }
    if (quality_.noise_m(k) > std::max(kNoise_m, 2 * device_.info().resolution_m))
      report(false, nameOf(k) + " is noisy at rest: damping and friction will be felt as a hum");
  }
  // A value that comes too seldom jumps too.
  if (valuesChange && quality_.glitches() > 0)
    report(false, "positions jump, " + std::to_string(quality_.glitches()) + " times, as no hand moves");
}

void DeviceCheck::judgeAxes() {
  for (int k = 0; k < 3; ++k) {
    if (!quality_.everChanged(k))
      report(false, nameOf(k) + " never changed: move the handle along it; if you did, it is not measured");
  }
}

void DeviceCheck::judgeForces(double force_N) {
  if (push(force_N)) {
    measureDelay(force_N);
    measureWatchdog(force_N);
    raiseStiffness(force_N);
  } else {
    line("not measured", "delay, watchdog and stiffness, before forces push the right way");
  }
  stop(force_N);
}

void DeviceCheck::letGo(double seconds) {
  for (double t = 0; t < seconds; t += period_s_) (void)tick(Vec3(0));
}

/// The mean position of some ticks in which it stays within a box so wide, or, where it does not soon, of any.
Vec3 DeviceCheck::restAt(double within_m) {
  constexpr int kMean = 100, kTries = 20;
  Vec3 mean(0);
  for (int tries = 0; tries < kTries; ++tries) {
    Vec3 sum(0), low(1e9), high(-1e9);
    for (int i = 0; i < kMean; ++i) {
      const Vec3 at = tick(Vec3(0)).position;
      sum += at;
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
    mean = sum / double{kMean};
    if (glm::length(high - low) < within_m) break;
  }
  return mean;
}

Vec3 DeviceCheck::pushFor(Vec3 force_N) {
  Vec3 at(0);
  for (double t = 0; t < kRamp_s + kHold_s; t += period_s_) at = tick(std::min(1.0, t / kRamp_s) * force_N).position;
  return at;
}

/// Pushes along each axis and looks where the hand goes. True: all of them the right way.
bool DeviceCheck::push(double force_N) {
  bool all = true;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 along(0);
    along[axis] = force_N;
    const Vec3 from = restAt(kResting_m);
    const Vec3 moved = pushFor(along) - from;
    int most = axis;
    for (int k = 0; k < 3; ++k) most = std::abs(moved[k]) > 2 * std::abs(moved[most]) ? k : most;
    const std::string name = "+" + nameOf(axis);
    line(("pushed along " + name).c_str(), "%+.2f, %+.2f, %+.2f mm", 1e3 * moved.x, 1e3 * moved.y, 1e3 * moved.z);
    const bool isRight = most == axis && moved[axis] > kMoved_m;
    all =
        report(isRight, std::abs(moved[most]) <= kMoved_m
                            ? name + " does not move the hand: held too tightly, or there is no force"
                        : most != axis ? name + " pushes along " + nameOf(most) + ": turn_rad, or axes in another order"
                        : isRight      ? name + " pushes the right way"
                                       : name + " pushes the other way: reversed_axes, or turn_rad") &&
        all;
    letGo(kBetween_s);
  }
  return all;
}

/// From a force that is written to the hand that moves by it: where it came from, as it moves with a constant acceleration.
/// 0: it was not moved far enough.
double DeviceCheck::delayOfTap_s(double force_N) {
  const double least_m = std::max({1e-4, 4 * quality_.noise_m(2), 2 * device_.info().resolution_m});
  const double from_m = restAt(2 * least_m).z;
  const std::uint64_t written_ns = time_.now_ns();
  std::array<double, 2> passed_s{};  // least_m, 4 least_m
  double last_s = 0, last_m = 0;
  for (double t = 0; t < kTap_s && passed_s[1] == 0; t += period_s_) {
    const DeviceReading reading = tick(Vec3(0, 0, force_N));
    const auto measured_ns = static_cast<double>(time_.now_ns()) - 1e3 * reading.status.age_us;
    const double now_s = 1e-9 * (measured_ns - static_cast<double>(written_ns)) - period_s_;  // written a tick later
    const double moved_m = reading.position.z - from_m;
    for (std::size_t i = 0; i < 2; ++i) {
      const double mark_m = least_m * (i == 0 ? 1 : 4);
      if (passed_s[i] == 0 && moved_m >= mark_m && moved_m > last_m)
        passed_s[i] = last_s + (now_s - last_s) * std::clamp((mark_m - last_m) / (moved_m - last_m), 0.0, 1.0);
    }
    last_s = now_s;
    last_m = moved_m;
  }
  letGo(kBetween_s / 2);
  return passed_s[1] == 0 ? 0 : std::max(1e-6, 2 * passed_s[0] - passed_s[1]);
}

void DeviceCheck::measureDelay(double force_N) {
  std::vector<double> delays_s;
  for (int i = 0; i < kTaps; ++i) {
    if (const double delay_s = delayOfTap_s(force_N); delay_s > 0) delays_s.push_back(delay_s);
  }
  if (delays_s.size() < kTaps / 2) {
    report(false, "taps are not felt within " + std::to_string(std::lround(1e3 * kTap_s)) + " ms");
    return;
  }
  const double delay_s = percentile(delays_s, 0.5), said_s = device_.info().delay_s;
  line("delay of a tap", "%.1f ms, %.1f to %.1f ms; it says %.1f ms", 1e3 * delay_s, 1e3 * percentile(delays_s, 0),
       1e3 * percentile(delays_s, 1), 1e3 * said_s);
  report(delay_s <= std::max(kLongestDelay_s, said_s + kLongestDelay_s / 2),
         "forces are in time for hard surfaces (10 ms, or what the device says)");
}

/// For how long it was, by the clock; there is no force afterwards. 0: it was not.
double DeviceCheck::standStill_s(double seconds, Vec3 force_N) {
  if (!time_.pauseProcess(seconds)) return 0;
  const std::uint64_t began_ns = time_.now_ns();
  double still_s = 0;
  for (std::uint64_t last_ns = began_ns; still_s == 0 && last_ns < began_ns + std::uint64_t{2'000'000'000};) {
    (void)tickBy([&](const DeviceReading&) {
      const double passed_s = 1e-9 * static_cast<double>(time_.now_ns() - std::exchange(last_ns, time_.now_ns()));
      if (passed_s >= 0.9 * seconds) still_s = passed_s;
      return still_s > 0 ? Vec3(0) : force_N;
    });
  }
  return still_s;
}

/// Stands still in the middle of a push. Nobody reads it meanwhile: how far the hand has come back afterwards tells how long the
/// force stayed.
void DeviceCheck::measureWatchdog(double force_N) {
  const Vec3 along(0, 0, force_N);
  const auto isBack = [](double from, double pushed, double at) { return at < from + 0.5 * (pushed - from); };
  double from_m = restAt(kResting_m).z, pushed_m = pushFor(along).z;
  double back_s = 0;
  for (double t = period_s_; t < kHold_s && back_s == 0; t += period_s_) {
    if (isBack(from_m, pushed_m, tick(Vec3(0)).position.z)) back_s = t;
  }
  if (pushed_m - from_m < kMoved_m || back_s == 0) {
    report(false, "the watchdog cannot be measured: the hand does not come back from a push");
    return;
  }
  for (const double pause_s : kPauses_s) {
    letGo(kBetween_s);
    from_m = restAt(kResting_m).z;
    pushed_m = pushFor(along).z;
    const double still_s = standStill_s(pause_s + back_s, along);
    if (still_s == 0) {
      line("watchdog", "not measured: this process cannot be paused");
      return;
    }
    double at_m = pushed_m;
    for (int i = 0, fresh = 0; i < 30 && fresh < 2; ++i) {
      at_m = tick(Vec3(0)).position.z;
      fresh += fresh_ ? 1 : 0;
    }
    if (!isBack(from_m, pushed_m, at_m)) continue;
    line("watchdog", "the force ends within %.0f ms of the last one that was written", 1e3 * (still_s - back_s));
    report(still_s - back_s <= kWatchdog_s, "the device takes its force away by itself");
    return;
  }
  report(false, "the force stays while this program stands still: the device has no watchdog of its own");
}

bool DeviceCheck::shakesAt(double stiffness_N_per_m, double force_N) {
  constexpr double kKick_s = 0.008, kSettle_s = 0.15, kWatch_s = 0.25;
  const Vec3 middle = restAt(kResting_m);
  std::array<std::vector<double>, 3> seen;
  for (double t = 0; t < kSettle_s + kWatch_s; t += period_s_) {
    const Vec3 at = tickBy([&](const DeviceReading& reading) {
                      if (t < kKick_s) return Vec3(0, 0, force_N);
                      const Vec3 spring = stiffness_N_per_m * (middle - reading.position);
                      const double length = glm::length(spring);
                      return length > force_N ? force_N / length * spring : spring;
                    }).position;
    for (std::size_t k = 0; k < 3 && t >= kSettle_s; ++k) seen[k].push_back(at[static_cast<int>(k)]);
  }
  letGo(kBetween_s / 5);
  return std::ranges::any_of(seen,
                             [&](const auto& axis) { return shakes(axis, kWatch_s, stiffness_N_per_m, force_N); });
}

/// A spring to where the hand is, stiffer and stiffer, until it shakes.
void DeviceCheck::raiseStiffness(double force_N) {
  const double said = device_.info().maxStiffness_N_per_m;
  const double most = said > 0 ? 2 * said : kMaxStiffness_N_per_m;
  double steady = 0, stiffness = kMinStiffness_N_per_m;
  for (; stiffness <= most && !shakesAt(stiffness, force_N); stiffness *= kStiffnessStep) steady = stiffness;
  if (stiffness > most) {
    line("stiffness", "steady at %.0f N/m, the most that was tried; it says %.0f N/m", steady, said);
  } else {
    line("stiffness", "shakes at %.0f N/m; safe in this hand is %.0f N/m; it says %.0f N/m", stiffness, steady / 2,
         said);
  }
  report(steady > 0 && steady * kStiffnessStep > said, "a spring is steady at the stiffness that the device says");
}

/// Lets go in the middle of a push, and looks how soon the hand comes back.
void DeviceCheck::stop(double force_N) {
  const Vec3 along(0, 0, force_N);
  (void)restAt(kResting_m);
  const Vec3 pushed = pushFor(along);
  device_.stop();
  double back_s = 0;
  for (double t = 0; t < kHold_s && back_s == 0; t += period_s_) {
    // A stopped device does not hear the force.
    if (tick(along).position.z < pushed.z - kMoved_m / 5) back_s = t;
  }
  if (back_s == 0) {
    report(false, "the hand does not come back after stop: let it go, or the force stays");
    return;
  }
  line("after stop", "it is on its way back within %.0f ms", 1e3 * back_s);
  report(back_s <= kStopWithin_s, "the force ends within 30 ms");
}

void DeviceCheck::line(const char* label, const char* format, ...) {
  char text[256];
  const int used = std::snprintf(text, sizeof text, "  %-16s", label);
  va_list values;
  va_start(values, format);
  std::vsnprintf(text + used, sizeof text - static_cast<std::size_t>(used), format, values);
  va_end(values);
  say_(text);
}

bool DeviceCheck::report(bool isGood, const std::string& finding) {
  say_((isGood ? "ok    " : "BAD   ") + finding);
  good_ = good_ && isGood;
  return isGood;
}

}  // namespace haptics
