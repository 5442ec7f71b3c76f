#pragma once

#include <condition_variable>
#include <deque>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "graphics_client/viewer/render_mesh.h"

namespace haptics {

/// Builds render meshes on a thread of its own, in the order of the requests; frames never wait for it.
class RenderMeshBuilder {
 public:
  using Pending = std::shared_future<std::shared_ptr<const RenderMesh>>;

  RenderMeshBuilder();
  /// Orders that are still waiting are dropped.
  ~RenderMeshBuilder();
  RenderMeshBuilder(const RenderMeshBuilder&) = delete;
  RenderMeshBuilder& operator=(const RenderMeshBuilder&) = delete;

  /// For one calling thread. A mesh that is in use, or being built, is not built twice.
  [[nodiscard]] Pending request(const SurfaceRequest& request);

  [[nodiscard]] static bool isReady(const Pending& pending) {
    return pending.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

 private:
  struct Known {
    SurfaceRequest request;
    Pending pending;
  };
  using Task = std::packaged_task<std::shared_ptr<const RenderMesh>()>;

  std::list<Known> known_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Task> waiting_;  // guarded by mutex_, as is stop_
  bool stop_ = false;
  std::thread thread_;

  void run();
  void forgetUnused();
};

}  // namespace haptics
