#pragma once

#include <span>
#include <string>
#include <string_view>

#include "haptic_server/device/usb/usb_port.h"

namespace haptics {

/// "001/004", as lsusb prints it and /dev/bus/usb names it.
[[nodiscard]] std::string addressOf(const UsbPlace& place);
/// "001/004 (port 1-4.2, serial FTX1)".
[[nodiscard]] std::string describe(const UsbPlace& place);

/// The one that is wanted: by serial number, by "BUS/ADDRESS" as lsusb prints it, or by port path; "" for the only one.
/// Refused: none; several and none chosen, with how to choose. `title` is the device's name for people.
[[nodiscard]] tl::expected<UsbPlace, UsbRefusal> chooseDevice(std::span<const UsbPlace> places, std::string_view wanted,
                                                              const std::string& title);

}  // namespace haptics
