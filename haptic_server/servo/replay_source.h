#pragma once

#include <cstdint>

#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

/// Ticks that a servo is to run again as they were, in place of those that its clock brings, and of the scenes that a
/// builder makes. For the servo's thread: wait-free, without allocation.
class ReplaySource {
 public:
  struct Tick {
    std::uint64_t index = 0;
    const ServoScene* newest = nullptr;  ///< The scene that came at its start; null: none did.
  };
  enum class Next : std::uint8_t { kTick, kNotYet, kEnd };

  virtual ~ReplaySource() = default;
  [[nodiscard]] virtual Next next(Tick& tick) noexcept = 0;
  /// Scenes before this one (ServoScene::number) are not used any more.
  virtual void releaseBefore(std::uint64_t scene) noexcept = 0;
};

}  // namespace haptics
