#pragma once

#include "haptic_server/device/usb/falcon_firmware.h"

namespace haptics::test {

/// A boot stream of the right form with a program that is none.
inline FalconFirmware someFirmware() {
  FalconFirmware bytes;
  const auto word = [&](unsigned value) {
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  };
  word(0x08AA);
  for (int i = 0; i < 8; ++i) word(0);
  word(0x003F);
  word(0x8000);
  for (const unsigned length : {200U, 7U, 300U}) {
    word(length);
    word(0);
    word(0x8000);
    for (unsigned i = 0; i < length; ++i) word(i * 37 & 0xFFFF);
  }
  word(0);
  return bytes;
}

}  // namespace haptics::test
