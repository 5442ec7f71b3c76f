#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <memory>

#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

/// Hands immutable scenes from the builder thread to the servo thread and takes them back when the servo is done.
/// One builder, one servo.
class SceneMailbox {
 public:
  /// Builder. The newest scene wins: one that the servo has not adopted yet is replaced and freed here.
  void publish(std::unique_ptr<const ServoScene> scene);
  /// Builder. Frees the scenes that the servo has left behind. Called now and then.
  void reclaim();

  /// Servo, wait-free. The scene to go over to, or null when nothing new was published. The scene used until now stays
  /// alive until adopted() is called.
  [[nodiscard]] const ServoScene* newest() noexcept;
  /// Servo, wait-free. The scene last returned by newest() is the only one in use from now on.
  void adopted() noexcept;

 private:
  struct Held {
    std::uint64_t sequence;
    std::unique_ptr<const ServoScene> scene;
  };
  std::list<Held> held_;  // builder only: all that the servo may still look at, oldest first
  std::uint64_t published_ = 0;
  std::atomic<const Held*> pending_{nullptr};
  std::uint64_t taken_ = 0;  // servo only
  std::atomic<std::uint64_t> adopted_{0};

  static_assert(std::atomic<const Held*>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);
};

}  // namespace haptics
