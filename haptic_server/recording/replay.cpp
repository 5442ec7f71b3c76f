#include "haptic_server/recording/replay.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "haptic_server/recording/recorded_run.h"
#include "haptic_server/recording/replayed_servo.h"

namespace haptics {
namespace {

using OnProgress = std::function<bool(const ReplayOutcome&)>;

/// Ticks that follow one another.
struct Stretch {
  std::vector<RecordedRunTick> ticks;
  std::vector<std::shared_ptr<const RemadeScene>> scenes;  // that they may use
  std::optional<RecordedBeginnings> next;                  // state that the recording has after them,
  std::string nextRefused;                                 // or why that is none
  std::uint64_t nextTick = 0;                              // that follows it
  double share = 0;                                        // of the recording that was read then
};

/// States of motion one after another, as far as they are in use.
class MotionStates {
 public:
  void add(const MotionState& motion) {
    put(bytes_, motion.tick);
    put(bytes_, motion.sceneRevision);
    put(bytes_, motion.tool);
    put(bytes_, motion.bodyCount);
    for (const BodyState& body : motion.bodies()) put(bytes_, body);
    put(bytes_, motion.dentCount);
    for (const ObjectDent& dent : motion.dents()) put(bytes_, dent);
    put(bytes_, motion.staying);
  }

  class Reader {
   public:
    explicit Reader(const MotionStates& states) : left_(states.bytes_) {}
    /// As many times as there are states. Valid until the next call.
    [[nodiscard]] const MotionState& next() {
      get(motion_.tick);
      get(motion_.sceneRevision);
      get(motion_.tool);
      get(motion_.bodyCount);
      for (BodyState& body : std::span(motion_.body).first(motion_.bodyCount)) get(body);
      get(motion_.dentCount);
      for (ObjectDent& dent : std::span(motion_.dent).first(motion_.dentCount)) get(dent);
      get(motion_.staying);
      return motion_;
    }

   private:
    std::string_view left_;
    MotionState motion_;

    template <class T>
    void get(T& value) {
      std::memcpy(static_cast<void*>(&value), left_.data(), sizeof value);
      left_.remove_prefix(sizeof value);
    }
  };

  void clear() { bytes_.clear(); }

 private:
  std::string bytes_;

  template <class T>
  static void put(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
};

/// What they come to.
struct Computed {
  struct Tick {
    TelemetrySample sample;
    std::uint64_t scene;  // ServoScene::number
    bool moved;           // has the next one of the motions
  };
  std::vector<Tick> ticks;  // where they are wanted, as the next two
  std::vector<TelemetrySample> secondSamples;
  MotionStates motions;
  ReplayCount count;
  std::unique_ptr<ReplayedServo> servo;  // after them
  bool meetsNext = false;                // its state is Stretch::next
  std::string differsIn;                 // where it is another one: the field

  /// Keeps the memory.
  void clear() {
    ticks.clear();
    secondSamples.clear();
    motions.clear();
    count = {};
  }
};

class StretchReader {
 public:
  explicit StretchReader(RecordedRun& run) : run_(run) { readTick(); }

  /// Reads on, to the next state that the recording holds. False: it has ended.
  [[nodiscard]] bool read(Stretch& stretch) {
    if (!tick_) return false;
    do {
      stretch.ticks.push_back(*tick_);
      stretch.share = run_.share();
      readTick();
    } while (tick_ && run_.keyframe() == nullptr && stretch.ticks.size() < kMaxTicks);
    stretch.scenes = run_.heldScenes();
    readState(stretch);
    return true;
  }
  /// Why that is before its end.
  [[nodiscard]] const std::optional<Error>& refusal() const noexcept { return refusal_; }

 private:
  static constexpr std::size_t kMaxTicks = 20'000;  // bounds what is kept of them

  RecordedRun& run_;
  std::optional<RecordedRunTick> tick_;  // that comes next
  std::optional<Error> refusal_;

  void readState(Stretch& stretch) const {
    if (!tick_ || run_.keyframe() == nullptr || !run_.sameStep()) return;
    stretch.nextTick = tick_->recorded[0].input.tick;
    if (auto state = run_.beginningsAt(*run_.keyframe())) {
      stretch.next = *std::move(state);
    } else {
      stretch.nextRefused = state.error().text();
    }
  }

  void readTick() {
    auto tick = run_.next();
    tick_ = tick ? *tick : std::nullopt;
    if (!tick) refusal_ = tick.error();
  }
};

/// False: it differs.
[[nodiscard]] bool compare(const RecordedTick& recorded, Vec3 force_N, const ReplayedServo::Tick& now, std::size_t hand,
                           ReplayCount& count) {
  const Vec3 torque_Nm = now.torque_Nm[hand];
  if (wroteSame(recorded, force_N, torque_Nm, now.grip_Nm[hand])) return true;
  if (!count.first) count.first = {count.ticks, recorded.input.tick, recorded.force_N, force_N};
  count.largestDifference_N = std::max(count.largestDifference_N, glm::distance(recorded.force_N, force_N));
  count.largestDifference_Nm = std::max({count.largestDifference_Nm, glm::distance(recorded.torque_Nm, torque_Nm),
                                         std::abs(recorded.grip_Nm - now.grip_Nm[hand])});
  return false;
}

/// @param next  Of ticks that come later.
void append(ReplayCount& count, const ReplayCount& next) {
  if (!count.first && next.first) {
    count.first = next.first;
    count.first->position += count.ticks;
  }
  count.ticks += next.ticks;
  count.contactTicks += next.contactTicks;
  count.differing += next.differing;
  count.largestDifference_N = std::max(count.largestDifference_N, next.largestDifference_N);
  count.largestDifference_Nm = std::max(count.largestDifference_Nm, next.largestDifference_Nm);
}

[[nodiscard]] const RemadeScene* find(const Stretch& stretch, std::uint64_t number) {
  const auto found = std::ranges::find(stretch.scenes, number, [](const auto& scene) { return scene->scene->number; });
  return found == stretch.scenes.end() ? nullptr : found->get();
}

class Replay {
 public:
  Replay(RecordedRun& run, const OnReplayedTick& onTick, const OnProgress& onProgress, ReplayOutcome& outcome)
      : run_(run), onTick_(onTick), onProgress_(onProgress), outcome_(outcome), reader_(run) {}
  ~Replay() { givenUp_ = true; }
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  void run() {
    const std::size_t ahead = std::max(2U, std::thread::hardware_concurrency());
    while (begin()) {
      while (underWay_.size() > ahead || (underWay_.size() > 1 && underWay_.front().isComputed())) {
        if (!finish()) return;
      }
    }
    while (!underWay_.empty()) {
      if (!finish()) return;
    }
    outcome_.refusal = reader_.refusal();
  }

 private:
  struct UnderWay {
    Stretch stretch;
    std::future<Computed> computed;  // from the state that the recording has before it; not valid: it has none

    [[nodiscard]] bool isComputed() const {
      return computed.valid() && computed.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    }
  };

  RecordedRun& run_;
  const OnReplayedTick& onTick_;
  const OnProgress& onProgress_;
  ReplayOutcome& outcome_;
  StretchReader reader_;
  std::atomic<bool> givenUp_{false};
  std::deque<UnderWay> underWay_;
  std::vector<Computed> spare_;  // memory for the next ones
  // After what is finished.
  std::unique_ptr<ReplayedServo> servo_;
  std::vector<std::shared_ptr<const RemadeScene>> scenes_;  // of the servo
  bool meetsNext_ = true;
  std::uint64_t lastTick_ = 0;

  /// The next stretch. False: there is none.
  [[nodiscard]] bool begin() {
    auto servo = recordedServo();
    UnderWay& last = underWay_.emplace_back();
    if (!reader_.read(last.stretch)) {
      underWay_.pop_back();
      return false;
    }
    if (!servo) return true;
    Computed room;
    if (!spare_.empty()) {
      room = std::move(spare_.back());
      spare_.pop_back();
    }
    last.computed = std::async(std::launch::async, [this, &stretch = last.stretch, servo = std::move(servo),
                                                    room = std::move(room)]() mutable {
      return compute(stretch, std::move(servo), std::move(room));
    });
    return true;
  }

  /// As the recording has it before the next stretch. Null: it has none.
  [[nodiscard]] std::unique_ptr<ReplayedServo> recordedServo() {
    const bool isFirst = underWay_.empty();  // later some stay under way
    if (!isFirst && !underWay_.back().stretch.next) return nullptr;
    auto servo = std::make_unique<ReplayedServo>(run_.facts());
    servo->begin(isFirst ? run_.beginnings() : *underWay_.back().stretch.next);
    return servo;
  }

  /// @param computed  Empty: its memory is used.
  [[nodiscard]] Computed compute(const Stretch& stretch, std::unique_ptr<ReplayedServo> servo,
                                 Computed computed = {}) const {
    const std::size_t hands = run_.facts().hands();
    ReplayCount& count = computed.count;
    if (onTick_) computed.ticks.reserve(stretch.ticks.size());
    for (const RecordedRunTick& tick : stretch.ticks) {
      if (givenUp_.load(std::memory_order_relaxed)) break;
      const ReplayedServo::Tick now = servo->take(tick);
      bool isSame = compare(tick.recorded[0], now.sample.force.written, now, 0, count);
      if (hands > 1) {
        const Vec3 force_N = now.secondSample.force.written;
        isSame = compare(tick.recorded[1], force_N, now, 1, count) && isSame;
      }
      if (!isSame) ++count.differing;
      if (now.sample.object != 0) ++count.contactTicks;
      ++count.ticks;
      if (!onTick_) continue;
      const MotionState* motion = servo->motionIfChanged(now.sample.tick);
      computed.ticks.push_back({now.sample, servo->scene(), motion != nullptr});
      if (hands > 1) computed.secondSamples.push_back(now.secondSample);
      if (motion != nullptr) computed.motions.add(*motion);
    }
    computed.differsIn = stretch.next ? servo->differenceFrom(*stretch.next) : stretch.nextRefused;
    computed.meetsNext = stretch.next && computed.differsIn.empty();
    computed.servo = std::move(servo);
    return computed;
  }

  /// The oldest stretch that is under way. False: the replay is to end.
  [[nodiscard]] bool finish() {
    UnderWay& oldest = underWay_.front();
    const std::uint64_t first = oldest.stretch.ticks.front().recorded[0].input.tick;
    Computed computed;
    if (oldest.computed.valid()) computed = oldest.computed.get();
    if (!computed.servo || !meetsNext_ || (servo_ && computed.count.differing > 0)) {
      if (computed.servo && meetsNext_) countDifferingState(first, "none of its fields");
      computed = compute(oldest.stretch, std::move(servo_));
    } else if (servo_) {
      outcome_.ticksAhead += computed.count.ticks;
    }
    const std::uint64_t last = oldest.stretch.ticks.back().recorded[0].input.tick;
    if (outcome_.ticks > 0) outcome_.missed += first - lastTick_ - 1;
    outcome_.missed += last - first + 1 - oldest.stretch.ticks.size();
    lastTick_ = last;
    append(outcome_, computed.count);
    if (!computed.differsIn.empty()) countDifferingState(oldest.stretch.nextTick, computed.differsIn);
    const bool goesOn = handOver(oldest.stretch, computed) && (!onProgress_ || onProgress_(outcome_));
    servo_ = std::move(computed.servo);
    scenes_ = std::move(oldest.stretch.scenes);
    meetsNext_ = computed.meetsNext;
    run_.releaseBefore(servo_->oldestScene());
    underWay_.pop_front();
    computed.clear();
    spare_.push_back(std::move(computed));
    return goesOn;
  }

  /// The state before this tick.
  void countDifferingState(std::uint64_t tick, const std::string& field) {
    if (outcome_.differingStates++ > 0) return;
    outcome_.firstDifferingState = tick;
    outcome_.differingField = field;
  }

  [[nodiscard]] bool handOver(const Stretch& stretch, const Computed& computed) const {
    MotionStates::Reader motions(computed.motions);
    auto second = computed.secondSamples.begin();
    const RemadeScene* scene = nullptr;
    std::uint64_t number = 0;
    for (const Computed::Tick& tick : computed.ticks) {
      if (tick.scene != std::exchange(number, tick.scene)) scene = find(stretch, number);
      if (!onTick_({tick.sample, tick.moved ? &motions.next() : nullptr,
                    computed.secondSamples.empty() ? nullptr : &*second++, scene, stretch.share}))
        return false;
    }
    return true;
  }
};

[[nodiscard]] ReplayOutcome replay(RecordedRun& run, const OnReplayedTick& onTick, const OnProgress& onProgress) {
  ReplayOutcome outcome;
  outcome.facts = run.facts();
  outcome.sameStep = run.sameStep();
  Replay(run, onTick, onProgress, outcome).run();
  outcome.scenes = run.scenes();
  outcome.cutOff = !outcome.refusal && run.cutOff();
  return outcome;
}

}  // namespace

std::string differenceIn(const ReplayOutcome& outcome) {
  std::string text;
  if (outcome.differing > 0) {
    char ticks[160];
    std::snprintf(ticks, sizeof ticks, "%llu ticks differ, by up to %.3g N and %.3g Nm, the first at tick %llu",
                  static_cast<unsigned long long>(outcome.differing), outcome.largestDifference_N,
                  outcome.largestDifference_Nm, static_cast<unsigned long long>(outcome.first->tick));
    text = ticks;
  }
  if (outcome.differingStates == 0) return text;
  if (!text.empty()) text += "; ";
  return text + std::to_string(outcome.differingStates) + " states are not those of the ticks beside, the first in " +
         outcome.differingField + " before tick " + std::to_string(outcome.firstDifferingState);
}

Result<ReplayOutcome> replay(RecordingBytes recording, const OnReplayedTick& onTick) {
  AssetStore store;
  const auto run = RecordedRun::open(std::move(recording), store);
  if (!run) return tl::unexpected(run.error());
  return replay(**run, onTick, {});
}

ReplayOutcome replay(std::unique_ptr<RecordingSource> recording, const OnProgress& onProgress) {
  AssetStore store;
  RecordedRun run(std::move(recording), store);
  return replay(run, {}, onProgress);
}

}  // namespace haptics
