#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// The program that a Falcon runs, as its maker's driver loads it into the device at each power-up. It may not be passed
/// on with this program: the user brings the file.
using FalconFirmware = std::vector<std::uint8_t>;

inline constexpr std::size_t kMaxFirmware_bytes = 256U << 10;  ///< More would not fit the controller's memory.

/// Refused, naming the offset and what belongs there: anything but a boot stream of the TMS320C28x, which is
/// little-endian 16-bit words: the key 0x08AA, eight reserved words, the entry point (two words), blocks of a length, an
/// address (two words) and as many words, and a length of 0 that ends it.
[[nodiscard]] Result<FalconFirmware> checkFirmware(FalconFirmware bytes);

[[nodiscard]] Result<FalconFirmware> readFirmware(const std::filesystem::path& file);

}  // namespace haptics
