#pragma once

#include <array>
#include <deque>

#include "tests/haptic_server/device/emulated/mechanics.h"
#include "tests/haptic_server/device/emulated/usb_model.h"

namespace haptics::test {

/// An FT232R serial converter and the Falcon behind it: boot loader, firmware, homing, encoders, buttons, lights, motors,
/// and a user, who homes it when its
/// blue light has been on for a while. Written from the protocol's facts, sharing only kinematics with the driver.
class FalconModel final : public EmulatedUsb {
 public:
  explicit FalconModel(std::string serial = "SIM00001");

  [[nodiscard]] std::vector<std::uint8_t> descriptors() const override;
  [[nodiscard]] std::string stringDescriptor(int index) const override;
  int control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint64_t now_ns) override;
  int out(std::span<const std::uint8_t> bytes, std::uint64_t now_ns) override;
  [[nodiscard]] std::optional<std::uint64_t> inReadyAt(std::uint64_t posted_ns) const override;
  int in(std::span<std::uint8_t> bytes, std::uint64_t now_ns) override;
  void clearHalt() override { halted_ = fault_ == EmulatedFault::kStall; }
  void advance(std::uint64_t now_ns) override;

  void setFault(EmulatedFault fault, std::uint64_t now_ns) override;
  void powerCycle() override;

  [[nodiscard]] Vec3 motorForce_N() const override { return motor_N_; }
  [[nodiscard]] bool motorsOn() const override { return motors_ != std::array<std::int16_t, 3>{}; }
  [[nodiscard]] std::uint64_t replies() const override { return replies_; }
  [[nodiscard]] std::size_t firmwareBytes() const { return firmwareBytes_; }
  /// What the homed bits say from now on, whatever is true.
  void setHomedBits(bool homed) { saysHomed_ = homed; }
  void press(unsigned buttons) { buttons_ = buttons; }

 private:
  enum class Mode { kBoot, kLoader, kRunning };

  void takeByte(std::uint8_t byte, std::uint64_t now_ns);
  void takeCommand(std::uint64_t now_ns);
  void say(std::span<const std::uint8_t> bytes, std::uint64_t ready_ns);
  [[nodiscard]] std::array<std::int16_t, 3> counts() const;

  std::string serial_;
  Mechanics mechanics_;
  Mode mode_ = Mode::kBoot;
  bool programmed_ = false;
  std::uint16_t baud_ = 0x4138;
  std::uint8_t lines_ = 0;
  std::uint64_t latency_ns_ = 16'000'000;
  std::uint16_t eventChar_ = 0;
  std::deque<std::uint8_t> heard_;
  struct Said {
    std::uint8_t byte;
    std::uint64_t ready_ns;
  };
  std::deque<Said> said_;
  std::uint64_t lastIn_ns_ = 0;
  std::array<std::int16_t, 3> motors_{};
  Vec3 motor_N_{0};
  unsigned lights_ = 0, buttons_ = 0;
  std::uint64_t blueSince_ns_ = 0;
  bool referenced_ = false, homingAsked_ = false;
  EmulatedFault fault_ = EmulatedFault::kNone;
  bool halted_ = false;
  std::optional<bool> saysHomed_;
  int jump_ = 0;
  std::uint64_t replies_ = 0;
  std::size_t firmwareBytes_ = 0;
};

}  // namespace haptics::test
