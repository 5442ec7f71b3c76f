#pragma once

#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "haptic_server/step/haptic_state.h"

namespace haptics {

template <class T>
requires std::is_trivially_copyable_v<T>
void put(std::string& image, const T& value) { image.append(reinterpret_cast<const char*>(&value), sizeof value); }

/// False: the image ends before.
template <class T>
requires std::is_trivially_copyable_v<T>
[[nodiscard]] bool take(std::string_view& image, T& value) {
  if (image.size() < sizeof value) return false;
  std::memcpy(static_cast<void*>(&value), image.data(), sizeof value);
  image.remove_prefix(sizeof value);
  return true;
}

/// Whether the byte of a flag that came from elsewhere is one. To read it as a flag before is undefined.
[[nodiscard]] inline bool isFlag(const bool& flag) { return *reinterpret_cast<const unsigned char*>(&flag) <= 1; }

[[nodiscard]] inline bool isPose(const Pose& pose) {
  constexpr double kRounding = 1e-3;
  return isWithinWorld(pose.position) && std::abs(glm::length(pose.rotation) - 1) <= kRounding;
}

}  // namespace haptics
