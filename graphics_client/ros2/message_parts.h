#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/maths/vec.h"
#include "graphics_client/ros2/message_types.h"

// Messages refer to strings and lists of the caller's, which outlive the writing.
namespace haptics::ros2 {

inline constexpr const char* kWorld = "world";  ///< Frame of what the server calls the world.

/// DDS's types for C do not know const; what is written is only read.
[[nodiscard]] inline char* text(const char* string) { return const_cast<char*>(string); }
[[nodiscard]] inline char* text(const std::string& string) { return text(string.c_str()); }

/// Sequence is one of idlc's.
template <class Sequence, class Value>
[[nodiscard]] Sequence sequenceOf(std::vector<Value>& values) {
  const auto count = static_cast<std::uint32_t>(values.size());
  return {count, count, values.data(), false};
}

/// @param stamp_ns  Since 1970.
[[nodiscard]] inline Header header(std::int64_t stamp_ns, const char* frame = kWorld) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  return {{static_cast<std::int32_t>(stamp_ns / kSecond), static_cast<std::uint32_t>(stamp_ns % kSecond)}, text(frame)};
}

[[nodiscard]] inline Vector3 vector3(Vec3 v) { return {v.x, v.y, v.z}; }
[[nodiscard]] inline Point point(Vec3 v) { return {v.x, v.y, v.z}; }
[[nodiscard]] inline Quaternion quaternion(Quat q) { return {q.x, q.y, q.z, q.w}; }

}  // namespace haptics::ros2
