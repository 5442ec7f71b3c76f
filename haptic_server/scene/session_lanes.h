#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// Queue of jobs: each session's run in their order, all by their arrival, and none waits for a job of another session that
/// is being prepared. One thread executes, any number prepare; not thread-safe.
///
/// A job is taken and finished; one that takes long is set aside, prepared by another thread, and taken again. The
/// later jobs of its session wait meanwhile. What was tried to be prepared, and takes too long for whoever tried, is
/// postponed: into a queue of its own, so that short work need not wait behind it.
///
/// Where there is no memory for an entry it throws, and the job is still its caller's; nothing else throws.
template <class TaskType>
class SessionLanes {
 public:
  using Task = TaskType;
  struct Job {
    SessionId session = kServerSession;
    std::uint64_t number = 0;  ///< Of its arrival.
    std::size_t size_bytes = 0;
    Task task;
  };

  /// \param most_bytes       Of all jobs that are not finished.
  /// \param maxOfSession_bytes  Of one session's, but for a single one: who floods the server fills half of it.
  explicit SessionLanes(std::size_t most_bytes, std::size_t maxOfSession_bytes)
      : maxBytes_(most_bytes), maxOfSession_bytes_(maxOfSession_bytes) {}

  /// False: there is no room for it now.
  [[nodiscard]] bool add(SessionId session, std::size_t size_bytes, Task task) {
    const auto known = lanes_.find(session);
    const std::size_t ofSession = known == lanes_.end() ? 0 : known->second.bytes;
    if (size_bytes > maxBytes_ - bytes_) return false;
    if (ofSession > 0 && ofSession + size_bytes > maxOfSession_bytes_) return false;
    Lane& lane = known == lanes_.end() ? lanes_.emplace(session, Lane(session)).first->second : known->second;
    lane.waiting.push_back({session, ++lastNumber_, size_bytes, std::move(task)});
    bytes_ += size_bytes;
    lane.bytes += size_bytes;
    if (lane.waiting.size() == 1) offer(lane);
    return true;
  }

  /// The next to be carried out, null where there is none: the oldest whose session has none that is being prepared.
  [[nodiscard]] const Job* next() const {
    return ready_.empty() ? nullptr : &lanes_.at(ready_.begin()->second).waiting.front();
  }
  /// Pops the job that next() shows.
  [[nodiscard]] Job take() {
    Lane& lane = lanes_.at(ready_.begin()->second);
    withdraw(lane, ready_.begin()->first);
    Job job = std::move(lane.waiting.front());
    lane.waiting.pop_front();
    offer(lane);
    return job;
  }
  /// Taken too early: behind one of its session that takes long. The last of several first.
  void putBack(Job&& job) {
    Lane& lane = lanes_.at(job.session);
    lane.waiting.push_front(std::move(job));
    if (lane.waiting.size() > 1) withdraw(lane, lane.waiting[1].number);
    offer(lane);
  }

  /// The taken job takes long: its session waits for it.
  void setAside(Job&& job) {
    Lane& lane = lanes_.at(job.session);
    aside_.push_back(std::move(job));
    if (!lane.waiting.empty()) withdraw(lane, lane.waiting.front().number);
    lane.prepares = aside_.back().number;
  }
  [[nodiscard]] bool anyAside() const noexcept { return !aside_.empty(); }
  [[nodiscard]] bool anyPostponed() const noexcept { return !postponed_.empty(); }
  /// The next to be prepared that was not postponed.
  [[nodiscard]] std::optional<Job> takeAside() { return popFrom(aside_); }
  /// The next to be prepared, postponed or not: the oldest.
  [[nodiscard]] std::optional<Job> takeAsideOrPostponed() {
    if (aside_.empty()) return popFrom(postponed_);
    const bool older = !postponed_.empty() && postponed_.front().number < aside_.front().number;
    return popFrom(older ? postponed_ : aside_);
  }
  /// The job that takeAside() gave takes long.
  void postpone(Job&& job) {
    postponed_.push_back(std::move(job));  // else it would be moved from before there is room
    const auto last = std::prev(postponed_.end());
    const auto isLater = [&](const Job& other) { return other.number > last->number; };
    std::rotate(std::find_if(postponed_.begin(), last, isLater), last, postponed_.end());
  }
  struct Queued {
    const Job* job;
    std::size_t place;  ///< 1: the next.
  };
  /// The session's job that waits to be prepared, if any; it is its only one.
  [[nodiscard]] std::optional<Queued> queued(SessionId session) const {
    for (const auto* queue : {&aside_, &postponed_}) {
      const auto at = std::ranges::find(*queue, session, &Job::session);
      if (at != queue->end()) return Queued{&*at, static_cast<std::size_t>(at - queue->begin()) + 1};
    }
    return std::nullopt;
  }
  /// The job may be executed.
  void prepared(Job&& job) {
    Lane& lane = lanes_.at(job.session);
    lane.waiting.push_front(std::move(job));
    lane.prepares = 0;
    offer(lane);
  }

  /// The job is carried out, or dropped, wherever it was.
  void finished(const Job& job) noexcept {
    const auto at = lanes_.find(job.session);
    Lane& lane = at->second;
    bytes_ -= job.size_bytes;
    lane.bytes -= job.size_bytes;
    if (lane.prepares == job.number) {
      lane.prepares = 0;
      offer(lane);
    }
    if (lane.bytes == 0 && lane.waiting.empty() && lane.prepares == 0) lanes_.erase(at);
  }

  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  using Ready = std::map<std::uint64_t, SessionId>;
  struct Lane {
    explicit Lane(SessionId session) {
      Ready one{{0, session}};
      place = one.extract(one.begin());
    }
    std::deque<Job> waiting;
    std::uint64_t prepares = 0;       // number of the job that the session waits for; 0: none
    std::size_t bytes = 0;            // of jobs that are not finished
    typename Ready::node_type place;  // in ready_; empty while it is there
  };

  void offer(Lane& lane) noexcept {
    if (lane.prepares != 0 || lane.waiting.empty() || lane.place.empty()) return;
    lane.place.key() = lane.waiting.front().number;
    ready_.insert(std::move(lane.place));
  }
  void withdraw(Lane& lane, std::uint64_t number) noexcept {
    if (auto place = ready_.extract(number)) lane.place = std::move(place);
  }

  static std::optional<Job> popFrom(std::deque<Job>& queue) {
    if (queue.empty()) return std::nullopt;
    std::optional<Job> job(std::move(queue.front()));
    queue.pop_front();
    return job;
  }

  const std::size_t maxBytes_, maxOfSession_bytes_;
  std::map<SessionId, Lane> lanes_;
  Ready ready_;                        // sessions whose first job may be taken, by its number
  std::deque<Job> aside_, postponed_;  // each by its number
  std::size_t bytes_ = 0;
  std::uint64_t lastNumber_ = 0;
};

}  // namespace haptics
