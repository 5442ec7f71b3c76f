#pragma once

#include <cstdint>
#include <span>

namespace haptics {

/// Who takes a device's force away when the servo no longer runs: the watchdog, outside of this process.
class OutputWatchdog {
 public:
  virtual ~OutputWatchdog() = default;
  /// From now on there may be a force on the device. Driver's thread.
  /// @param node  Descriptor of the device's node, its interface claimed; the caller's.
  /// @param out  Endpoint address.
  /// @param zero  What is sent there to take the force away.
  virtual void arm(int node, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept = 0;
  /// There is none any more, and the node is about to be closed. Driver's thread.
  virtual void disarm() noexcept = 0;
  /// Times that the force was taken away so. Any thread, wait-free.
  [[nodiscard]] virtual std::uint64_t trips() const noexcept = 0;
};

}  // namespace haptics
