#pragma once

#include <cstddef>
#include <cstdint>

#include "common/error/error.h"
#include "graphics_client/mirror/mirror.h"
#include "graphics_client/mirror/mirror_view.h"
#include "haptic_server/recording/recorded_scenes.h"

namespace haptics {

/// The scenes of a replay as a client would hold them.
class ReplayMirror {
 public:
  /// @param epoch  Of the views.
  explicit ReplayMirror(std::uint64_t epoch) : epoch_(epoch) {}

  /// @param remade  ReplayedTick::scene.
  /// @return Whether it is another one than in the last call. Refused: it cannot be held.
  [[nodiscard]] Result<bool> follow(const RemadeScene* remade);
  /// Of the assets that came with the newest scene.
  [[nodiscard]] std::size_t addedBytes() const noexcept { return added_bytes_; }
  [[nodiscard]] MirrorView view() const { return mirror_.contents(); }

 private:
  const std::uint64_t epoch_;
  Mirror mirror_;
  bool any_ = false;
  std::uint64_t number_ = 0;
  std::size_t added_bytes_ = 0;
};

}  // namespace haptics
