#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/maths/vec.h"

// OpenIGTLink's messages, as far as the bridge speaks them: TRANSFORM, POSITION, SENSOR in the first version of the header.
// Its lengths are millimetres; here they are metres.
namespace haptics::igtl {

inline constexpr std::size_t kMaxName = 20;  ///< Bytes of a device's name.

/// @param name  At most kMaxName bytes. @param unix_ns  Since 1970.
[[nodiscard]] std::string transform(std::string_view name, std::int64_t unix_ns, const Pose& pose);
[[nodiscard]] std::string position(std::string_view name, std::int64_t unix_ns, const Pose& pose);
/// In newtons.
[[nodiscard]] std::string force(std::string_view name, std::int64_t unix_ns, Vec3 force_N);

/// A message that came, as far as its header tells. Valid within the call that it is passed to.
struct Message {
  std::string_view type, name;
  std::string_view content;  ///< Without an extended header and what follows the content.
};

/// Of the content of a TRANSFORM; the rotation is of length 1. Refused: another length, a number that is not finite, a matrix
/// that does not turn.
[[nodiscard]] Result<Pose> poseFrom(std::string_view content);

/// Cuts a stream into messages.
class Reader {
 public:
  /// Longer ones, such as pictures, are read over.
  static constexpr std::uint64_t kMaxBody_bytes = 4096;

  /// Gives each whole message to `take`. Refused: what is none; nothing can be read any more then.
  [[nodiscard]] Result<void> read(std::span<const char> bytes, const std::function<void(const Message&)>& take);

 private:
  std::string held_;           // the begin of a message
  std::uint64_t toLeave_ = 0;  // bytes of one that is read over
};

}  // namespace haptics::igtl
