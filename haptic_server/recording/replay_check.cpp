#include "haptic_server/recording/replay_check.h"

#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>

#include "common/clock/monotonic.h"
#include "haptic_server/recording/replay.h"

namespace haptics {
namespace {

constexpr int kNice = 10;  // of the replaying threads

}  // namespace

/// The parts of a run, as they come.
class ReplayCheck::Parts final : public RecordingSource {
 public:
  explicit Parts(ReplayCheck& check) : RecordingSource(check.facts_), check_(check) {}

  [[nodiscard]] Result<const v1::RecordingPart*> next() override {
    std::unique_lock lock(check_.mutex_);
    check_.changed_.wait(lock, [this] { return !check_.parts_.empty() || check_.isEnded_; });
    if (check_.parts_.empty()) return nullptr;
    part_ = std::move(check_.parts_.front());
    check_.parts_.pop_front();
    return &part_;
  }

 private:
  ReplayCheck& check_;
  v1::RecordingPart part_;
};

ReplayCheck::ReplayCheck(RecordingFacts facts, std::function<void(const std::string&)> warning)
    : facts_(std::move(facts)),
      warning_(std::move(warning)),
      mostBehind_(static_cast<std::uint64_t>(FlightRing::kSeconds * facts_.rate_Hz)),
      thread_([this] { run(); }) {}

void ReplayCheck::add(std::span<const Keyframe> keyframes, const AddScenes& addScenes) {
  if (!encoder_) {
    {
      const std::lock_guard lock(mutex_);
      if (isReplaying_ || endsBy_ns_) return;
      isReplaying_ = true;
      isEnded_ = false;
    }
    encoder_.emplace(*this);
    const Keyframe& oldest = *std::ranges::min_element(keyframes, {}, &Keyframe::scene);
    addScenes(*encoder_, std::max<std::uint64_t>(oldest.scene, 1));
  }
  encoder_->add(keyframes);
}

void ReplayCheck::add(std::span<const RecordedTick> tick) {
  if (encoder_) {
    encoder_->add(tick);
  } else {
    ++skipped_;
  }
}

void ReplayCheck::put(const v1::RecordingPart& part) {
  const std::lock_guard lock(mutex_);
  (isEnded_ ? count_.skipped : behind_) += part.ticks().ticks().size() / kTickBytes;
  if (!isEnded_) parts_.push_back(part);
  changed_.notify_all();
}

void ReplayCheck::flush(bool isWhole) {
  if (encoder_) encoder_->putTicks();
  std::unique_lock lock(mutex_);
  count_.skipped += std::exchange(skipped_, 0);
  const bool isLate = behind_ > mostBehind_;
  if (isWhole && !isLate && !isEnded_) return;
  lock.unlock();
  endRun();
  if (isLate && !std::exchange(saidLate_, true))
    warning_("--check-replay: the replay cannot keep up with the servo; ticks are skipped");
}

void ReplayCheck::endRun() noexcept {
  encoder_.reset();
  const std::lock_guard lock(mutex_);
  isEnded_ = true;
  changed_.notify_all();
}

void ReplayCheck::finish() {
  if (!thread_.joinable()) return;
  flush(false);
  {
    const std::lock_guard lock(mutex_);
    endsBy_ns_ = monotonicNow_ns() + kEndsWithin_ns;
  }
  changed_.notify_all();
  thread_.join();
}

ReplayCheck::Count ReplayCheck::count() const {
  const std::lock_guard lock(mutex_);
  return count_;
}

void ReplayCheck::run() {
  setpriority(PRIO_PROCESS, 0, kNice);  // this thread's, and of those that it starts
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return isReplaying_ || endsBy_ns_; });
    if (!isReplaying_) return;
    lock.unlock();
    replayRun();
    lock.lock();
  }
}

void ReplayCheck::replayRun() {
  std::uint64_t ticks = 0;  // counted
  std::string difference;
  try {
    const ReplayOutcome outcome = replay(std::make_unique<Parts>(*this), [&](const ReplayOutcome& soFar) {
      const std::lock_guard lock(mutex_);
      const std::uint64_t more = soFar.ticks - std::exchange(ticks, soFar.ticks);
      count_.ticks += more;
      behind_ -= more;
      return differenceIn(soFar).empty() && !(endsBy_ns_ && monotonicNow_ns() > *endsBy_ns_);
    });
    difference = outcome.refusal ? outcome.refusal->text() : differenceIn(outcome);
  } catch (const std::exception& failure) {  // as without memory
    warning_(std::string("--check-replay: ticks are skipped: ") + failure.what());
  }
  {
    const std::lock_guard lock(mutex_);
    count_.skipped += std::exchange(behind_, 0);
    parts_.clear();
    isEnded_ = true;
    isReplaying_ = false;
    if (difference.empty() || count_.differences++ > 0) return;
    count_.first = difference;
  }
  warning_("--check-replay: " + difference);
}

}  // namespace haptics
