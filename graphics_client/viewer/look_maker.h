#pragma once

#include <condition_variable>
#include <deque>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "graphics_client/viewer/look.h"

namespace haptics {

/// Makes looks on a thread of its own, in the order in which they were asked for; frames never wait for it.
class LookMaker {
 public:
  using Coming = std::shared_future<std::shared_ptr<const Look>>;

  LookMaker();
  /// Orders that are still waiting are dropped.
  ~LookMaker();
  LookMaker(const LookMaker&) = delete;
  LookMaker& operator=(const LookMaker&) = delete;

  /// Of one thread. What is in use already, or on its way, is not made twice.
  [[nodiscard]] Coming order(const LookOrder& order);

  [[nodiscard]] static bool isReady(const Coming& coming) {
    return coming.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

 private:
  struct Known {
    LookOrder order;
    Coming coming;
  };
  using Task = std::packaged_task<std::shared_ptr<const Look>()>;

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
