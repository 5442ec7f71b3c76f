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
inline constexpr std::size_t kMaxFrameBytes = 1U << 20;
/// Bulk data goes in chunks of at most this, so that heartbeats and edits interleave on a slow link.
inline constexpr std::size_t kMaxChunkBytes = 32U << 10;

/// Limits for both directions of a connection. Other values than the protocol's are for tests.
struct FrameLimits {
  std::size_t frame_bytes = kMaxFrameBytes;
  std::size_t chunk_bytes = kMaxChunkBytes;  ///< Of bulk data, and at least one object.
};

/// Appends the frame (little-endian u32 length, then the message) to `out`. Refused, with nothing appended: a message
/// of more bytes than the limit.
[[nodiscard]] Result<void> appendFrame(std::string& out, const v1::Envelope& envelope,
                                       std::size_t limit = kMaxFrameBytes);

/// Cuts a byte stream into envelopes. After an error it repeats that error: the connection is to be closed.
class FrameDecoder {
 public:
  FrameDecoder() = default;
  explicit FrameDecoder(std::size_t limit) noexcept : limit_(limit) {}
  /// From the next frame on.
  void setLimit(std::size_t limit) noexcept { limit_ = limit; }
  /// Takes the bytes over; then call next() until it returns nothing. Memory held: one frame and one feed.
  void feed(std::span<const char> bytes);
  /// The next whole envelope; an empty optional when more bytes are needed; an error for a frame of length 0 or above
  /// the limit, bytes that are not an Envelope, or an envelope without a body. A wrong protocol_version is the
  /// session's to answer.
  [[nodiscard]] Result<std::optional<v1::Envelope>> next();

 private:
  std::size_t limit_ = kMaxFrameBytes;
  std::string buffer_;
  std::size_t consumed_ = 0;
  std::optional<Error> broken_;
};

}  // namespace haptics
