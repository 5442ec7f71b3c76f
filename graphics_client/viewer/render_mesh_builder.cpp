#include "graphics_client/viewer/render_mesh_builder.h"

#include <algorithm>
#include <utility>

namespace haptics {

RenderMeshBuilder::RenderMeshBuilder() : thread_([this] { run(); }) {}

RenderMeshBuilder::~RenderMeshBuilder() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

RenderMeshBuilder::Pending RenderMeshBuilder::request(const SurfaceRequest& request) {
  forgetUnused();
  const auto at = std::ranges::find_if(known_, [&](const Known& known) { return known.request.sameAs(request); });
  if (at != known_.end()) return at->pending;
  Task task([request] { return std::make_shared<const RenderMesh>(buildRenderMesh(request)); });
  Known& known = known_.emplace_back(Known{request, task.get_future().share()});
  {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(task));
  }
  wake_.notify_one();
  return known.pending;
}

/// Made, and held by nobody but this list.
void RenderMeshBuilder::forgetUnused() {
  std::erase_if(known_,
                [](const Known& known) { return isReady(known.pending) && known.pending.get().use_count() == 1; });
}

void RenderMeshBuilder::run() {
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
