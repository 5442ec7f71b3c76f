#include "haptic_server/scene/work_watch.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <new>
#include <sstream>
#include <stop_token>
#include <utility>

namespace haptics {
namespace {

#ifdef HAPTICS_SANITIZED
constexpr double kSlower = 20;
#else
constexpr double kSlower = 1;
#endif

}  // namespace

WorkWatch::WorkWatch(const WorkLimits& limits, std::function<void()> stop, std::function<bool()> isEnough)
    : limits_{kSlower * limits.time_s, limits.memory_bytes},
      thread_([this, stop = std::move(stop), isEnough = std::move(isEnough)](const std::stop_token& done) {
        watch(done, stop, isEnough);
      }) {}

void WorkWatch::watch(const std::stop_token& done, const std::function<void()>& stop,
                      const std::function<bool()>& isEnough) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any never;
  while (!never.wait_for(lock, done, kEvery, [&done] { return done.stop_requested(); })) {
    try {
      if (tooMuch() || (isEnough && isEnough())) return stop();
    } catch (const std::bad_alloc&) {  // for the words: later, anew
    }
  }
}

std::optional<Error> WorkWatch::tooMuch() {
  const std::lock_guard lock(mutex_);
  if (!exceeded_) exceeded_ = measure();
  return exceeded_;
}

std::optional<Error> WorkWatch::measure() const {
  const double time_s = meter_.time_s(), memory_bytes = static_cast<double>(meter_.held_bytes());
  if (time_s <= limits_.time_s && memory_bytes <= limits_.memory_bytes) return std::nullopt;
  std::ostringstream text;
  text.precision(3);
  text << "were ended when they had taken " << time_s << " s of a processor and " << memory_bytes / 1e9
       << " GB; the server gives one edit " << limits_.time_s << " s and " << limits_.memory_bytes / 1e9
       << " GB, whatever its price: give less detail, or send them in several";
  return Error{"operations", text.str()};
}

}  // namespace haptics
