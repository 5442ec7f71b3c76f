#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "haptic_server/bring_up/position_quality.h"
#include "haptic_server/device/device.h"

namespace haptics {

/// The time in which a device is checked.
class CheckTime {
 public:
  virtual ~CheckTime() = default;
  [[nodiscard]] virtual std::uint64_t now_ns() = 0;
  virtual void sleepUntil(std::uint64_t time_ns) = 0;
  /// Soon nothing of this process runs for so long, but does not wait for that. False: it cannot be paused.
  [[nodiscard]] virtual bool pauseProcess(double seconds) = 0;
};

/// Reads and pushes a device as the servo does, and says what is wrong with it.
class DeviceCheck {
 public:
  /// @param say  Called with each finding, a line without its end.
  DeviceCheck(Device& device, CheckTime& time, double rate_Hz, std::function<void(const std::string&)> say);

  /// False: it is not within 30 s, and nothing else is to be asked.
  [[nodiscard]] bool waitUntilReady();
  /// Rate, age, values, noise, glitches, while somebody moves it.
  void readPositions(double seconds);
  /// Directions, delay, watchdog, stiffness and stop, while somebody holds it; the device does not push afterwards.
  void judgeForces(double force_N);
  /// Last: which axes never changed.
  void judgeAxes();
  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  Device& device_;
  CheckTime& time_;
  double period_s_;
  std::uint64_t next_ns_, tick_ = 0;
  std::function<void(const std::string&)> say_;
  PositionQuality quality_;
  bool fresh_ = false;             ///< The last reading had a new position.
  std::uint64_t measured_ns_ = 0;  ///< It.
  bool good_ = true;

  /// The force that follows from the reading is written.
  template <class Force>
  DeviceReading tickBy(Force forceOf);
  DeviceReading tick(Vec3 force_N);
  void letGo(double seconds);
  [[nodiscard]] Vec3 restAt(double within_m);
  [[nodiscard]] Vec3 pushFor(Vec3 force_N);

  [[nodiscard]] bool push(double force_N);
  void measureDelay(double force_N);
  [[nodiscard]] double delayOfTap_s(double force_N);
  void measureWatchdog(double force_N);
  [[nodiscard]] double standStill_s(double seconds, Vec3 force_N);
  void raiseStiffness(double force_N);
  [[nodiscard]] bool shakesAt(double stiffness_N_per_m, double force_N);
  void stop(double force_N);

  void line(const char* label, const char* format, ...) __attribute__((format(printf, 3, 4)));
  bool report(bool isGood, const std::string& finding);
};

}  // namespace haptics
