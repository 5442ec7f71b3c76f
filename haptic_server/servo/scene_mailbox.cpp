#include "haptic_server/servo/scene_mailbox.h"

#include <utility>

namespace haptics {

void SceneMailbox::publish(std::unique_ptr<const ServoScene> scene) {
  held_.push_back({++published_, std::move(scene)});
  const Held* replaced = pending_.exchange(&held_.back(), std::memory_order_acq_rel);
  if (replaced) held_.remove_if([replaced](const Held& held) { return &held == replaced; });
  reclaim();
}

void SceneMailbox::reclaim() {
  const std::uint64_t adopted = adopted_.load(std::memory_order_acquire);
  while (!held_.empty() && held_.front().sequence < adopted) held_.pop_front();
}

const ServoScene* SceneMailbox::newest() noexcept {
  if (!pending_.load(std::memory_order_relaxed)) return nullptr;
  const Held* newest = pending_.exchange(nullptr, std::memory_order_acq_rel);
  taken_ = newest->sequence;
  return newest->scene.get();
}

void SceneMailbox::adopted() noexcept { adopted_.store(taken_, std::memory_order_release); }

}  // namespace haptics
