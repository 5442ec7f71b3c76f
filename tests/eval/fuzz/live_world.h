#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/recording/flight_recorder.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/servo/servo_loop.h"
#include "tests/eval/fuzz/random_edits.h"

namespace haptics::eval {

/// How a world is set up; drawn from a seed.
struct LiveSetup {
  double rate_Hz = 1000;
  bool stabilised = true;
  std::size_t hands = 1;
  double rise_s = 0;
  std::array<DevicePreset, kMaxHands> device;
  DeviceLimits limits;

  static LiveSetup drawnFrom(Random& random);
  [[nodiscard]] StepConfig stepOf(const DeviceInfo& device) const;
};

/// A hand that wanders among the objects, presses, rests and lets go.
class WanderingHand final : public HandIntent {
 public:
  explicit WanderingHand(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] HandTarget next(double dt_s, Vec3 felt_N) noexcept override;
  [[nodiscard]] Quat nextRotation(double dt_s) noexcept override;

 private:
  Random random_;
  Vec3 place_m_{0, 0, 0.06}, goal_m_{0, 0, 0.06};
  double speed_m_per_s_ = 0, left_s_ = 0;
  Vec3 axis_{0, 0, 1};
  double angle_rad_ = 0, turn_rad_per_s_ = 0;
};

/// A simulated device that fails now and then.
class FailingDevice final : public Device {
 public:
  FailingDevice(const DevicePreset& preset, double rate_Hz, std::uint64_t seed);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return device_.info(); }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override;
  void write(Vec3 force_N) noexcept override { device_.write(force_N); }
  void writeTorque(Vec3 torque_Nm) noexcept override { device_.writeTorque(torque_Nm); }
  void stop() noexcept override {}

 private:
  enum class Failure : std::uint8_t { kNone, kLost, kNotFinite, kStale, kNotHomed, kJump };

  WanderingHand hand_;
  SimulatedDevice device_;
  Random random_;
  Failure failure_ = Failure::kNone;
  std::uint64_t until_ = 0;
};

/// A server without its processes: builder, servo loop and flight recorder in virtual time, while random edits come. The same
/// seed is the same run, bit for bit.
class LiveWorld final : private ReplaySource {
 public:
  /// @param recording  The file that its recorder writes.
  LiveWorld(std::uint64_t seed, double duration_s, const std::filesystem::path& recording);

  /// Refused: the recording could not be written.
  [[nodiscard]] Result<void> run();

  [[nodiscard]] const LiveSetup& setup() const noexcept { return setup_; }
  [[nodiscard]] std::uint64_t ticks() const noexcept { return ran_; }
  [[nodiscard]] std::uint64_t accepted() const noexcept { return accepted_; }  ///< Edits.
  [[nodiscard]] std::uint64_t contactTicks() const noexcept { return loop_->hand().statistics().contactTicks; }

 private:
  [[nodiscard]] Next next(Tick& tick) noexcept override;
  void releaseBefore(std::uint64_t /*scene*/) noexcept override {}
  void edit();
  [[nodiscard]] std::uint64_t now_ns() const noexcept;

  Random random_;
  LiveSetup setup_;
  RandomEdits edits_;
  std::uint64_t end_, tick_ = 0, ran_ = 0;
  std::uint64_t buildDue_ = 0, editDue_ = 0;
  std::uint64_t submitted_ = 0, accepted_ = 0;
  std::deque<FailingDevice> devices_;
  SceneMailbox mailbox_;
  std::unique_ptr<ServoLoop> loop_;
  std::unique_ptr<FlightRing> ring_;
  std::unique_ptr<FlightRecorder> recorder_;
  std::unique_ptr<SceneService> scenes_;
};

}  // namespace haptics::eval
