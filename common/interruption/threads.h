#pragma once

#include <exception>
#include <thread>
#include <vector>

#include "common/interruption/interruption.h"
#include "common/interruption/work_meter.h"

namespace haptics {

/// Calls `work` in `threads` threads at once, the calling one among them, and returns when all have. In the others it is
/// interruptible as in the calling one, and counts for the same meter.
/// Throws what one of them throws, when all have ended.
template <class Work>
void runInThreads(int threads, const Work& work) {
  std::vector<std::exception_ptr> thrown(threads > 1 ? static_cast<std::size_t>(threads - 1) : 0);
  {
    std::vector<std::jthread> others;
    others.reserve(thrown.size());
    for (std::exception_ptr& mine : thrown) {
      others.emplace_back([&work, &mine, token = Interruptible::token(), meter = WorkMeter::current()] {
        const Interruptible as(token);
        const WorkMeter::Counting counting(meter);
        try {
          work();
        } catch (...) {
          mine = std::current_exception();
        }
      });
    }
    work();
  }
  for (const std::exception_ptr& one : thrown) {
    if (one) std::rethrow_exception(one);
  }
}

}  // namespace haptics
