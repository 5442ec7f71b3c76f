#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "haptic_server/device/usb/usb_protocol.h"

namespace haptics {

/// What is written to a Falcon: 16 characters between '<' and '>', numbers as hexadecimal digits counted from 'A', the
/// lowest first.
struct FalconCommand {
  std::array<std::int16_t, 3> motors{};
  bool homing = false;  ///< In every frame, else it forgets its homing.
  bool green = false, blue = false, red = false;
};

inline constexpr std::size_t kFalconFrame_bytes = 16;
using FalconFrame = std::array<std::uint8_t, kFalconFrame_bytes>;

[[nodiscard]] FalconFrame encode(const FalconCommand& command) noexcept;

/// Finds replies in a stream of bytes of which some may be missing, doubled or wrong. A frame is 16 bytes from '<' to '>'
/// with digits between them; whatever is not is skipped up to the next '<', and counted. Bits of the buttons: 0 plus,
/// 1 forward, 2 centre, 3 minus.
class FalconReplyReader {
 public:
  /// Takes one byte; the reply that it completes, if it does.
  [[nodiscard]] std::optional<DeviceReply> take(std::uint8_t byte) noexcept;
  [[nodiscard]] std::uint64_t skippedBytes() const noexcept { return skipped_; }

 private:
  void drop() noexcept;

  FalconFrame frame_{};
  std::size_t filled_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace haptics
