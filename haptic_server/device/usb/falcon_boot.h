#pragma once

#include <optional>

#include "haptic_server/device/usb/falcon_firmware.h"
#include "haptic_server/device/usb/usb_port.h"

namespace haptics {

/// Brings an opened Falcon to where it answers commands at 1.5 Mbaud: asks whether it already does, else greets its boot
/// loader, loads the firmware, of which it echoes every byte, and asks again.
[[nodiscard]] std::optional<UsbRefusal> bootFalcon(UsbPort& port, UsbBus& bus,
                                                   const std::optional<FalconFirmware>& firmware);

}  // namespace haptics
