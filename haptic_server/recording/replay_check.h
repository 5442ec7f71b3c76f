#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "haptic_server/recording/recording_writer.h"

namespace haptics {

/// Replays what a servo has just run, from each state to the next, on a thread of its own. When that is more than
/// FlightRing::kSeconds behind, or comes to something else than the servo did, it goes on at a later state; what lies
/// between is not checked. Keeps the scene a second time.
class ReplayCheck {
 public:
  struct Count {
    std::uint64_t ticks = 0;        ///< Replayed.
    std::uint64_t skipped = 0;      ///< Not to be replayed any more.
    std::uint64_t differences = 0;  ///< Times that a force or a state came out otherwise.
    std::string first;              ///< Of them, in words.
  };
  /// Adds the scenes from this one on (ServoScene::number).
  using AddScenes = std::function<void(RecordingEncoder&, std::uint64_t from)>;

  /// @param warning  Gets the first difference, and says once that ticks are skipped. Any thread.
  ReplayCheck(RecordingFacts facts, std::function<void(const std::string&)> warning);
  ~ReplayCheck() { finish(); }
  ReplayCheck(const ReplayCheck&) = delete;
  ReplayCheck& operator=(const ReplayCheck&) = delete;

  // One thread, not the servo's:

  /// To add scenes to; null: none is wanted yet.
  [[nodiscard]] RecordingEncoder* encoder() noexcept { return encoder_ ? &*encoder_ : nullptr; }
  /// As to a RecordingEncoder.
  void add(std::span<const Keyframe> keyframes, const AddScenes& addScenes);
  void add(std::span<const RecordedTick> tick);
  /// Hands over what was added. @param isWhole  False: ticks are missing after it.
  void flush(bool isWhole = true);
  /// What was added and not handed over is not checked.
  void endRun() noexcept;
  /// Once all is replayed, or kEndsWithin_ns over.
  void finish();

  /// Any thread.
  [[nodiscard]] Count count() const;

 private:
  static constexpr std::uint64_t kEndsWithin_ns = 2'000'000'000;

  class Encoder final : public RecordingEncoder {
   public:
    explicit Encoder(ReplayCheck& check) : check_(check) {}

   private:
    void put(const v1::RecordingPart& part) override { check_.put(part); }
    ReplayCheck& check_;
  };
  class Parts;

  void put(const v1::RecordingPart& part);
  void run();
  void replayRun();

  const RecordingFacts facts_;
  const std::function<void(const std::string&)> warning_;
  const std::uint64_t mostBehind_;  // ticks

  // The thread that adds.
  std::optional<Encoder> encoder_;  // of the run that is replayed; none: the next state may begin one
  std::uint64_t skipped_ = 0;       // ticks since flush()
  bool saidLate_ = false;

  mutable std::mutex mutex_;  // guards the below
  std::condition_variable changed_;
  std::deque<v1::RecordingPart> parts_;  // to be replayed
  bool isReplaying_ = false;             // a run
  bool isEnded_ = true;                  // it gets no more parts
  std::uint64_t behind_ = 0;             // its ticks that are not replayed yet
  std::optional<std::uint64_t> endsBy_ns_;
  Count count_;
  std::thread thread_;
};

}  // namespace haptics
