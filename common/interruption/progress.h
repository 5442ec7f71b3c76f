#pragma once

#include <cstdint>
#include <functional>
#include <utility>

// Long work that says how far it is: whoever starts it makes a ProgressWatch, and what takes long reports now and then.
namespace haptics {

enum class WorkStage : std::uint8_t {
  kMaking = 1,  ///< Read from a file, or generated: in another process, of which not more is known.
  kBuilding     ///< Collision mesh and detail are built from it.
};

/// While it lives, this thread's reports go to the listener; the innermost one counts.
class ProgressWatch {
 public:
  /// Gets the stage and the share of it that is done, from 0 to 1.
  using Listener = std::function<void(WorkStage stage, double share)>;

  explicit ProgressWatch(Listener listener) : listener_(std::move(listener)), outer_(std::exchange(current_, this)) {}
  ~ProgressWatch() { current_ = outer_; }
  ProgressWatch(const ProgressWatch&) = delete;
  ProgressWatch& operator=(const ProgressWatch&) = delete;

 private:
  friend void reportProgress(WorkStage stage, double share);
  static inline thread_local ProgressWatch* current_ = nullptr;
  const Listener listener_;
  ProgressWatch* const outer_;
};

/// Costs a few nanoseconds where nobody listens.
inline void reportProgress(WorkStage stage, double share) {
  if (ProgressWatch::current_ != nullptr && ProgressWatch::current_->listener_) {
    ProgressWatch::current_->listener_(stage, share);
  }
}

}  // namespace haptics
