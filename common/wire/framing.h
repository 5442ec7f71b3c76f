#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/error/error.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

inline constexpr std::uint32_t kProtocolVersion = 1;
/// Largest frame after its length. A larger claim is refused before anything is allocated for it.
inline constexpr std::uint32_t kMaxFrameBytes = 1U << 20;
/// Bulk data goes in chunks of at most this, so that heartbeats and edits interleave on a slow link.
inline constexpr std::size_t kMaxChunkBytes = 32U << 10;

/// Appends the frame (little-endian u32 length, then the message) to `out`. The message must fit kMaxFrameBytes.
void appendFrame(std::string& out, const v1::Envelope& envelope);

/// Cuts a byte stream into envelopes. After an error it repeats that error: the connection is to be closed.
class FrameDecoder {
 public:
  /// Takes the bytes over; then call next() until it returns nothing. Memory held: one frame and one feed.
  void feed(std::span<const char> bytes);
  /// The next whole envelope; an empty optional when more bytes are needed; an error for a frame of length 0 or above
  /// kMaxFrameBytes, bytes that are not an Envelope, or an envelope without a body. A wrong protocol_version is the
  /// session's to answer.
  [[nodiscard]] Result<std::optional<v1::Envelope>> next();

 private:
  std::string buffer_;
  std::size_t consumed_ = 0;
  std::optional<Error> broken_;
};

}  // namespace haptics
