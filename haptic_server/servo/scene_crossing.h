#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>

#include "haptic_server/servo/servo_scene.h"

namespace haptics {

/// Hands immutable scenes from the builder thread to the servo thread and takes them back when the servo is done.
/// One builder, one servo.
class SceneCrossing {
 public:
  /// Builder. The newest scene wins: one that the servo has not adopted yet is replaced and freed here.
  void publish(std::unique_ptr<const ServoScene> scene);
  /// Builder. Frees the scenes that the servo has left behind. Called now and then.
  void reclaim();

  /// Servo, wait-free. The scene to use from now on, or null when nothing new was published.
  [[nodiscard]] const ServoScene* adopt() noexcept;

 private:
  struct Held {
    std::uint64_t sequence;
    std::unique_ptr<const ServoScene> scene;
  };
  std::deque<Held> held_;  // builder only: all that the servo may still look at, oldest first
  std::uint64_t published_ = 0;
  std::atomic<const Held*> pending_{nullptr};
  std::atomic<std::uint64_t> adopted_{0};
};

}  // namespace haptics
