#pragma once

#include <array>

#include "tests/haptic_server/device/emulated/mechanics.h"
#include "tests/haptic_server/device/emulated/usb_model.h"

namespace haptics::test {

/// A WoodenHaptics' controller and arm: a HID that reports each millisecond, encoders that count from where it was
/// switched on, a watchdog of half a second, and a user, who lays the arm into its rest pose when nobody talks to
/// it, and takes it up when somebody has for two seconds.
class WoodenModel final : public EmulatedUsb {
 public:
  static constexpr std::uint64_t kWatchdog_ns = 500'000'000;

  WoodenModel();

  [[nodiscard]] std::vector<std::uint8_t> descriptors() const override;
  [[nodiscard]] std::string stringDescriptor(int index) const override;
  int control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint64_t now_ns) override;
  int out(std::span<const std::uint8_t> bytes, std::uint64_t now_ns) override;
  [[nodiscard]] std::optional<std::uint64_t> inReadyAt(std::uint64_t posted_ns) const override;
  int in(std::span<std::uint8_t> bytes, std::uint64_t now_ns) override;
  void clearHalt() override { halted_ = fault_ == EmulatedFault::kStall; }
  void advance(std::uint64_t now_ns) override;

  void shiftFrames(std::uint64_t by_ns) override { lastIn_ns_ += by_ns; }
  void setFault(EmulatedFault fault, std::uint64_t now_ns) override;
  void powerCycle() override;

  [[nodiscard]] Vec3 motorForce_N() const override { return motor_N_; }
  [[nodiscard]] bool motorsOn() const override { return motors_ != std::array<std::int16_t, 3>{}; }
  [[nodiscard]] std::uint64_t replies() const override { return reports_; }

 private:
  [[nodiscard]] Vec3 angles() const;
  [[nodiscard]] std::array<std::int16_t, 3> counts() const;

  Mechanics mechanics_;
  bool held_ = false;
  double taken_ = 0;  // of the way from the rest pose to the hand, 0 to 1
  std::array<std::int16_t, 3> motors_{};
  Vec3 motor_N_{0};
  std::uint64_t talkSince_ns_ = 0;
  std::uint64_t lastIn_ns_ = 0, lastOut_ns_ = 0, lastAdvance_ns_ = 0;
  EmulatedFault fault_ = EmulatedFault::kNone;
  bool halted_ = false;
  int jump_ = 0;
  std::uint64_t reports_ = 0;
};

}  // namespace haptics::test
