#pragma once

#include <cerrno>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/maths/vec.h"

namespace haptics::test {

/// What can be wrong with a device or its cable.
enum class EmulatedFault {
  kNone,
  kShifted,   ///< Packets begin with bytes that belong to none, and lose as many at their end.
  kShort,     ///< Packets end early.
  kSilence,   ///< It takes commands and says nothing.
  kStall,     ///< Its IN endpoint halts.
  kSlow,      ///< Replies come 12 ms late.
  kUnhomed,   ///< It drops a homed bit.
  kJump,      ///< Its counters take a step.
  kGlitch,    ///< A step of some 4 mm.
  kFirmware,  ///< A byte of firmware is echoed wrong.
};
[[nodiscard]] std::optional<EmulatedFault> emulatedFault(const std::string& name);

/// A USB device that exists in a program only: what stands behind the emulated usbfs node, and behind the virtual bus of
/// unit tests. Times are nanoseconds of whatever clock the caller keeps; results are byte counts or negative errno, as in
/// the kernel.
class EmulatedUsb {
 public:
  virtual ~EmulatedUsb() = default;
  /// Device descriptor, then the configuration's.
  [[nodiscard]] virtual std::vector<std::uint8_t> descriptors() const = 0;
  [[nodiscard]] virtual std::string stringDescriptor(int index) const = 0;
  virtual int control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint64_t now_ns) = 0;
  virtual int out(std::span<const std::uint8_t> bytes, std::uint64_t now_ns) = 0;
  /// When an IN request that was posted at `posted_ns` completes, as far as is known now; never before something else
  /// happens: none.
  [[nodiscard]] virtual std::optional<std::uint64_t> inReadyAt(std::uint64_t posted_ns) const = 0;
  virtual int in(std::span<std::uint8_t> bytes, std::uint64_t now_ns) = 0;
  virtual void clearHalt() = 0;
  /// Mechanics up to now.
  virtual void advance(std::uint64_t now_ns) = 0;

  /// The bus's frames begin so much later from now on; nothing for a device that answers commands.
  virtual void shiftFrames(std::uint64_t /*by_ns*/) {}
  virtual void setFault(EmulatedFault fault, std::uint64_t now_ns) = 0;
  /// As after switching off and on, or plugging in anew.
  virtual void powerCycle() = 0;
  [[nodiscard]] virtual bool motorsOn() const = 0;
  [[nodiscard]] virtual Vec3 motorForce_N() const = 0;  ///< On the hand; x right, y away from the user, z up.
  [[nodiscard]] virtual std::uint64_t replies() const = 0;
};

}  // namespace haptics::test
