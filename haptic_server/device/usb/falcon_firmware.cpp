#include "haptic_server/device/usb/falcon_firmware.h"

#include <cstdio>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

namespace haptics {
namespace {

constexpr unsigned kKey = 0x08AA;
constexpr std::size_t kHeader_words = 11;  // key, 8 reserved, entry point
constexpr std::size_t kBlockHead_words = 3;

[[nodiscard]] unsigned wordAt(const FalconFirmware& bytes, std::size_t word) {
  return bytes[2 * word] | static_cast<unsigned>(bytes[2 * word + 1]) << 8;
}

[[nodiscard]] std::string hex(unsigned number) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%04X", number);
  return text;
}

[[nodiscard]] std::string atByte(std::size_t word) { return " at byte " + std::to_string(2 * word); }

}  // namespace

Result<FalconFirmware> checkFirmware(FalconFirmware bytes) {
  if (bytes.size() > kMaxFirmware_bytes) {
    return refused("", "has " + std::to_string(bytes.size()) + " bytes; a Falcon's firmware has at most " +
                           std::to_string(kMaxFirmware_bytes));
  }
  if (bytes.size() < 2 || wordAt(bytes, 0) != kKey) {
    return refused("", "does not begin with the boot key " + hex(kKey) +
                           (bytes.size() < 2 ? "" : " but with " + hex(wordAt(bytes, 0))) +
                           ": this is no Falcon firmware (it is the .bin file that other drivers load)");
  }
  const std::size_t words = bytes.size() / 2;
  std::size_t at = kHeader_words;
  for (;;) {
    if (at >= words)
      return refused("", "is cut off" + atByte(words) + ": the block of length 0 that ends it is missing");
    const unsigned length = wordAt(bytes, at);
    if (length == 0) break;
    if (words - at < kBlockHead_words + length) {
      return refused("", "is cut off: the block" + atByte(at) + " has " + std::to_string(length) + " words, of which " +
                             std::to_string(words - at > kBlockHead_words ? words - at - kBlockHead_words : 0) +
                             " are there");
    }
    at += kBlockHead_words + length;
  }
  if (at == kHeader_words) return refused("", "holds no program: its first block has length 0");
  if (2 * (at + 1) != bytes.size()) {
    return refused("", "goes on for " + std::to_string(bytes.size() - 2 * (at + 1)) + " bytes after its end" +
                           atByte(at + 1) + ": this is not the firmware alone");
  }
  return bytes;
}

Result<FalconFirmware> readFirmware(const std::filesystem::path& file) {
  FalconFirmware bytes;
  std::error_code error;
  if (std::filesystem::is_regular_file(file, error)) {
    std::ifstream in(file, std::ios::binary);
    bytes.resize(kMaxFirmware_bytes + 1);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(in.gcount()));
  }
  if (bytes.empty()) return refused(file.string(), "cannot be read, or is empty");
  auto checked = checkFirmware(std::move(bytes));
  if (!checked) return tl::unexpected(Error{file.string(), std::move(checked.error().reason)});
  return checked;
}

}  // namespace haptics
