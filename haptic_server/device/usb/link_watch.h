#pragma once

#include <algorithm>
#include <cstdint>

#include "common/telemetry/device_status.h"

namespace haptics {

/// Judges from what is sent and what comes back whether a device can be felt through. Times are nanoseconds of one
/// monotonic clock.
class LinkWatch {
 public:
  /// Without a whole reply in cycles of so long together, the device counts as silent: in a servo that reads each
  /// millisecond, that is felt within 5 ms. Cycles, not time, because a driver that was held up has asked nothing
  /// meanwhile; the servo sees by itself how old a position is.
  static constexpr std::uint64_t kSilence_ns = 3'000'000;
  /// Replies to commands that are older count as late; one period more than is in flight on a full-speed bus.
  static constexpr std::uint64_t kLate_ns = 4'500'000;
  static constexpr int kRecovery = 25;  ///< Good replies in a row after which a fault is over.
  /// A reply that never came is forgotten after this time: more than four a second are told from late ones.
  static constexpr std::uint64_t kForget_ns = 250'000'000;
  /// While replies are late, nothing is sent until none has come for so long: then all are in.
  static constexpr std::uint64_t kQuiet_ns = 15'000'000;

  LinkWatch(std::uint64_t now_ns, std::uint64_t period_ns, bool answersEachCommand) noexcept
      : period_ns_(period_ns), answersEach_(answersEachCommand), lastReply_ns_(now_ns), forgot_ns_(now_ns) {}

  /// A period of sending and receiving is over.
  void cycle() noexcept { ++silentCycles_; }
  void sent() noexcept { outstanding_ += answersEach_; }
  void reply(std::uint64_t now_ns) noexcept {
    lastReply_ns_ = now_ns;
    silentCycles_ = 0;
    outstanding_ -= outstanding_ > 0;
    if (!late()) ++good_;
  }
  /// Something came that is no whole reply.
  void garbled(std::uint64_t now_ns) noexcept {
    lastGarbage_ns_ = now_ns;
    outstanding_ -= outstanding_ > 0;
  }
  /// A fault that was seen, not inferred. The first cause stays until all is well again; silence alone gives way to one that says more.
  void raise(DeviceFault fault) noexcept {
    good_ = 0;
    if (fault_ == DeviceFault::kNone || fault_ == DeviceFault::kSilent) fault_ = fault;
  }
  [[nodiscard]] DeviceFault judge(std::uint64_t now_ns) noexcept {
    if (now_ns - forgot_ns_ > kForget_ns) {
      forgot_ns_ = now_ns;
      outstanding_ -= outstanding_ > 0;
    }
    if (!draining_ && silent()) {
      raise(lastGarbage_ns_ > lastReply_ns_ ? DeviceFault::kGarbled : DeviceFault::kSilent);
    }
    if (late() && !silent()) raise(DeviceFault::kLate);
    if (good_ >= kRecovery) fault_ = DeviceFault::kNone;
    return fault_;
  }
  /// May a command be sent? With late replies only while there is a force to take away.
  [[nodiscard]] bool maySend(std::uint64_t now_ns, bool forceIsGone) noexcept {
    if (!draining_ && late() && forceIsGone) draining_ = true;
    if (draining_ && now_ns - lastReply_ns_ > kQuiet_ns) {
      draining_ = false;
      outstanding_ = 0;
      lastReply_ns_ = now_ns;
      silentCycles_ = 0;
    }
    return !draining_;
  }

 private:
  [[nodiscard]] bool silent() const noexcept { return silentCycles_ * period_ns_ >= kSilence_ns; }
  [[nodiscard]] bool late() const noexcept { return outstanding_ * period_ns_ > kLate_ns; }

  std::uint64_t period_ns_;
  bool answersEach_;
  DeviceFault fault_ = DeviceFault::kNone;
  std::uint64_t lastReply_ns_, lastGarbage_ns_ = 0, forgot_ns_;
  std::uint64_t outstanding_ = 0, silentCycles_ = 0;
  int good_ = 0;
  bool draining_ = false;
};

/// The driver's own last word on the force, whatever the servo does: away within kAway_s of a fault, back within kBack_s.
class OutputGain {
 public:
  static constexpr double kAway_s = 0.02, kBack_s = 0.05;

  [[nodiscard]] double next(bool faulty, double elapsed_s) noexcept {
    gain_ = std::clamp(gain_ + elapsed_s * (faulty ? -1 / kAway_s : 1 / kBack_s), 0.0, 1.0);
    return gain_;
  }
  /// At once.
  void cut() noexcept { gain_ = 0; }
  [[nodiscard]] bool gone() const noexcept { return gain_ <= 0; }

 private:
  double gain_ = 0;
};

}  // namespace haptics
