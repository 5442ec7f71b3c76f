#include "graphics_client/viewer/look_maker.h"

#include <algorithm>
#include <utility>

namespace haptics {

LookMaker::LookMaker() : thread_([this] { run(); }) {}

LookMaker::~LookMaker() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

LookMaker::Coming LookMaker::order(const LookOrder& order) {
  forgetUnused();
  const auto at = std::ranges::find_if(known_, [&](const Known& known) { return known.order.sameAs(order); });
  if (at != known_.end()) return at->coming;
  Task task([order] { return std::make_shared<const Look>(makeLook(order)); });
  Known& known = known_.emplace_back(Known{order, task.get_future().share()});
  {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(task));
  }
  wake_.notify_one();
  return known.coming;
}

/// Made, and held by nobody but this list.
void LookMaker::forgetUnused() {
  std::erase_if(known_,
                [](const Known& known) { return isReady(known.coming) && known.coming.get().use_count() == 1; });
}

void LookMaker::run() {
  for (;;) {
    Task task;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
      if (stop_) return;
      task = std::move(waiting_.front());
      waiting_.pop_front();
    }
    task();
  }
}

}  // namespace haptics
