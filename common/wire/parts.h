#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "common/wire/checks.h"
#include "haptics/v1/scene.pb.h"

// Parts of messages, as the conversions of this folder share them.
namespace haptics {

[[nodiscard]] inline tl::unexpected<Error> refuse(Refusal bad) { return tl::unexpected<Error>(*std::move(bad)); }

/// Puts a part into `to`, or returns its error as seen from one level farther out: prefix + field.
template <class T, class To>
[[nodiscard]] Refusal take(Result<T> part, To& to, const std::string& prefix = {}) {
  if (!part) return std::move(part.error()).within(prefix);
  to = *std::move(part);
  return std::nullopt;
}

/// What an edit says of a property: nothing where it is not `given`; that it goes, by an empty message; or what `from`
/// reads.
template <class Message, class T>
[[nodiscard]] Refusal takeEdit(bool given, const Message& message, Result<T> (*from)(const Message&),
                               std::optional<std::optional<T>>& to, const std::string& prefix) {
  if (!given) return std::nullopt;
  to.emplace();
  return message.ByteSizeLong() == 0 ? Refusal() : take(from(message), *to, prefix);
}

[[nodiscard]] inline Vec3 vectorFrom(const v1::Vector3& message) { return {message.x(), message.y(), message.z()}; }
[[nodiscard]] inline Quat rotationFrom(const v1::Quaternion& message) {
  return {message.w(), message.x(), message.y(), message.z()};
}

/// To length 1. What has it but for rounding stays as it is: a state that an edit gives back is the same state.
/// \param value  Of a length near 1.
template <class T>
[[nodiscard]] T normalised(const T& value) {
  // Several times what glm::normalize leaves; larger would take lengths for 1 that can be told from it.
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  return std::abs(glm::dot(value, value) - 1) <= kRounding ? value : glm::normalize(value);
}

inline void toWire(const Vec3& vector, v1::Vector3& message) {
  message.set_x(vector.x);
  message.set_y(vector.y);
  message.set_z(vector.z);
}
inline void toWire(const Quat& rotation, v1::Quaternion& message) {
  message.set_w(rotation.w);
  message.set_x(rotation.x);
  message.set_y(rotation.y);
  message.set_z(rotation.z);
}

}  // namespace haptics
