#include "haptic_server/device/usb/falcon_frame.h"

namespace haptics {
namespace {

constexpr std::uint8_t kZero = 'A';
constexpr std::size_t kDigits = 4;  // of a number
constexpr std::size_t kFlags = 13;

[[nodiscard]] std::int16_t numberAt(const FalconFrame& frame, std::size_t axis) noexcept {
  unsigned number = 0;
  for (std::size_t digit = 0; digit < kDigits; ++digit) {
    number |= static_cast<unsigned>(frame[1 + kDigits * axis + digit] - kZero) << (4 * digit);
  }
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(number));
}

/// May this byte stand there? Flags use seven bits, all else four.
[[nodiscard]] bool fits(std::size_t place, std::uint8_t byte) noexcept {
  if (place == 0) return byte == '<';
  if (place == kFalconFrame_bytes - 1) return byte == '>';
  return byte >= kZero && byte - kZero < (place == kFlags ? 0x80 : 0x10);
}

}  // namespace

FalconFrame encode(const FalconCommand& command) noexcept {
  FalconFrame frame;
  frame.front() = '<';
  frame.back() = '>';
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto number = static_cast<std::uint16_t>(command.motors[axis]);
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
      frame[1 + kDigits * axis + digit] = static_cast<std::uint8_t>(kZero + (number >> (4 * digit) & 0xF));
    }
  }
  const int flags = command.homing | command.green << 1 | command.blue << 2 | command.red << 3;
  frame[kFlags] = static_cast<std::uint8_t>(kZero + flags);
  frame[kFlags + 1] = kZero;
  return frame;
}

std::optional<DeviceReply> FalconReplyReader::take(std::uint8_t byte) noexcept {
  frame_[filled_++] = byte;
  while (filled_ > 0 && !fits(filled_ - 1, frame_[filled_ - 1])) drop();
  if (filled_ < kFalconFrame_bytes) return std::nullopt;
  filled_ = 0;
  DeviceReply reply;
  for (std::size_t axis = 0; axis < 3; ++axis) reply.counts[axis] = numberAt(frame_, axis);
  const unsigned flags = frame_[kFlags] - kZero;
  reply.buttons = flags & 0xF;
  reply.homedAxes = flags >> 4 & 0x7;
  return reply;
}

/// The frame so far is none: goes on from the next '<' in it. What was before the last byte has fitted, so that only the
/// last one can be a '<'.
void FalconReplyReader::drop() noexcept {
  const std::uint8_t last = frame_[filled_ - 1];
  const bool restarts = filled_ > 1 && last == '<';
  skipped_ += filled_ - (restarts ? 1 : 0);
  filled_ = restarts ? 1 : 0;
  frame_[0] = last;
}

}  // namespace haptics
