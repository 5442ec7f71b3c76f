#pragma once

#include <cstdint>
#include <cstdio>
#include <deque>
#include <functional>
#include <string>

#include "tests/sim/virtual_time.h"

namespace haptics::sim {

/// What happened in a world, in words. Off while seeds are tried by the thousand; a seed that fails is run again with
/// it on.
class EventLog {
 public:
  enum class Mode { kOff, kLast, kPrint };
  static constexpr std::size_t kKept = 60;

  EventLog(Mode mode, const VirtualTime& time) : mode_(mode), time_(time) {}

  /// The line is made only when somebody is going to read it.
  template <class MakeLine>
  void add(const MakeLine& makeLine) {
    if (mode_ == Mode::kOff) return;
    char stamp[32];
    std::snprintf(stamp, sizeof stamp, "%9.4f s  ", 1e-9 * static_cast<double>(time_.now_ns()));
    const std::string line = stamp + std::string(makeLine());
    if (mode_ == Mode::kPrint) {
      std::printf("%s\n", line.c_str());
      return;
    }
    if (ended_) return;
    last_.push_back(line);
    if (last_.size() > kKept) last_.pop_front();
  }
  /// What is of interest has happened: the last lines stay as they are.
  void end() noexcept { ended_ = true; }
  [[nodiscard]] const std::deque<std::string>& last() const noexcept { return last_; }

 private:
  Mode mode_;
  const VirtualTime& time_;
  bool ended_ = false;
  std::deque<std::string> last_;
};

}  // namespace haptics::sim
