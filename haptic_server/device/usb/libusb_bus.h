#pragma once

#include <memory>
#include <vector>

#include "common/clock/monotonic.h"
#include "haptic_server/device/usb/usb_port.h"

namespace haptics {

/// The machine's own USB, by libusb 1.0. Each look at it and each opened device has a context of its own: a new one sees
/// what is plugged in now, and devices do not wait for one another.
class LibusbBus final : public UsbBus {
 public:
  [[nodiscard]] std::uint64_t clock_ns() noexcept override { return monotonicNow_ns(); }
  void sleepUntil(std::uint64_t time_ns) override;
  [[nodiscard]] std::vector<UsbPlace> list(const UsbModel& model) override;
  [[nodiscard]] tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> open(const UsbModel& model,
                                                                        const UsbPlace& place) override;
};

}  // namespace haptics
