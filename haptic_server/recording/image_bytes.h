#pragma once

#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/maths/rotation.h"
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

[[nodiscard]] inline bool isPose(const Pose& pose) { return isWithinWorld(pose.position) && isRotation(pose.rotation); }

/// @param observer  As it begins.
[[nodiscard]] inline bool takeObserver(std::string_view& image, PredictiveObserver& observer) {
  PredictiveObserver later;
  if (image.empty() || image.front() != 1) return false;  // its first byte: that it is active
  if (!take(image, later) || !observer.couldBecome(later)) return false;
  observer = later;
  return true;
}

}  // namespace haptics
