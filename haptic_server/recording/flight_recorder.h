#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "haptic_server/recording/recording_quota.h"
#include "haptic_server/recording/recording_writer.h"
#include "haptic_server/recording/replay_check.h"
#include "haptic_server/recording/scene_journal.h"

namespace haptics {

/// Empties the servo's flight ring into recordings, on a thread of its own: the last FlightRing::kSeconds when a fault has
/// come up or somebody asks, and every tick from the first on where a file is given.
class FlightRecorder {
 public:
  struct Options {
    RecordingFacts facts;          ///< Of this server; began and why are left to the recorder.
    std::string record;            ///< File for every tick; empty: none.
    std::filesystem::path folder;  ///< For the others.
    RecordingQuota quota = {};     ///< Of the folder.
    /// Memory of the scenes that a recording after a crash needs (SceneJournal), another one from time to time: its
    /// descriptor, which is the recorder's. On the thread of onSceneBuilt(), before the servo gets a scene that is only there; of
    /// scenes of more than kKeptAtOnce_bytes on the recorder's, soon after.
    std::function<void(int descriptor)> keepScenes = {};
    std::function<void(const std::string&)> info, warning;
    /// From one state in the file of every tick to the next, at least: parts of that length are replayed at the same time.
    std::uint64_t ticksPerState = 5'000;
    bool checkReplay = false;  ///< Replays what the servo has just run.
  };
  /// Where the recording is, or why there is none. On the recorder's thread.
  using Answer = std::function<void(const Result<std::filesystem::path>&)>;

  /// How often ticks go to the file. Killed, a server loses those of so long at most; longer risks more, shorter costs
  /// wake-ups beside the servo.
  static constexpr std::uint64_t kFlushEvery_ns = 20'000'000;
  static constexpr double kAfterFault_s = 0.5;  ///< Kept of what comes after a fault: how the force was taken away.
  /// Recordings of faults by one server: a device that comes and goes must not fill the disk.
  static constexpr int kMaxFaults = 20;
  /// What they may keep the disk busy with: after one of a large scene the next fault is recorded only when this rate is
  /// kept, 30 s after 235 MB (12.6 million triangles).
  static constexpr double kFaultBytes_per_s = 8e6;
  static constexpr std::uint64_t kBetweenRequests_ns = 1'000'000'000;  ///< Between two requests that are granted.
  /// Assets of a scene that onSceneBuilt() itself keeps for after a crash; to keep more takes tens of milliseconds.
  static constexpr std::size_t kKeptAtOnce_bytes = 4U << 20;

  /// The ring outlives the recorder. Refused: a file that cannot be written.
  [[nodiscard]] static Result<std::unique_ptr<FlightRecorder>> open(Options options, FlightRing& ring);
  ~FlightRecorder();  ///< Stops.
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// A scene that the servo is about to get. Any one thread, also before start(). Where it throws, it has not taken it.
  void onSceneBuilt(const ServoScene& scene, const std::vector<ServoObjectSource>& objects);
  void start();
  /// In place of start(), for virtual time: takes what the ring holds, on this thread.
  void collect() { look(false); }
  /// Any thread. Writes the last FlightRing::kSeconds, unless somebody else has just asked.
  void request(std::string why, Answer answer);
  /// Writes what the ring still holds; after the servo's last tick. Refused: the file is incomplete.
  [[nodiscard]] Result<void> stop();
  /// Any thread. Null: it is not asked for.
  [[nodiscard]] const ReplayCheck* check() const noexcept { return check_ ? &*check_ : nullptr; }

 private:
  struct Request {
    std::string why;
    Answer answer;
    std::uint64_t due = 0;  // position in the ring
  };
  struct Held {
    std::shared_ptr<const SceneSource> scene;
    std::uint64_t built_ns;
  };
  FlightRecorder(Options options, FlightRing& ring) : options_(std::move(options)), ring_(ring) {}

  void run();
  void look(bool last);
  void takeTicks(std::uint64_t end);
  void take(std::span<const RecordedTick> tick);
  void addState(const FlightRing::HeldKeyframes& keyframes);
  void writeDue(std::uint64_t end, bool last);
  [[nodiscard]] bool mayBeGranted(const Request& request);
  [[nodiscard]] bool mayBeRecorded(Fault fault);
  void pauseAfter(const std::filesystem::path& recording);
  [[nodiscard]] std::vector<std::shared_ptr<const SceneSource>> scenesFrom(std::uint64_t number) const;
  void addScenes(RecordingEncoder& to, std::uint64_t from) const;
  void giveUp(const std::string& why);
  void releaseScenes();
  void keep(const SceneSource* scene);
  void keepDue();
  [[nodiscard]] Result<void> keepAnew(std::uint64_t upTo);

  Options options_;
  FlightRing& ring_;
  std::thread thread_;

  mutable std::mutex mutex_;  // guards the six below
  std::condition_variable changed_;
  std::list<Held> scenes_;
  std::deque<Request> asked_;
  bool running_ = false;
  bool stopping_ = false;
  // To keep in the journal; not empty while the recorder's thread is at it.
  std::list<std::shared_ptr<const SceneSource>> toKeep_;

  // The thread of onSceneBuilt(), unless there are scenes to keep: then the recorder's.
  std::optional<SceneJournal> journal_;
  std::uint64_t journalBegan_ = 0;  // its size with the scenes that it began with
  bool keepsScenes_ = true;         // no: there was no memory

  // The recorder's thread only.
  std::optional<RecordingWriter> writer_;
  std::optional<ReplayCheck> check_;
  std::optional<Error> failure_;  // of --record
  std::uint64_t seen_ = 0;        // ticks
  std::uint64_t stateDue_ = 0;    // at the first keyframe from this tick on
  std::array<bool, kMaxHands> wasGood_{};
  int faults_ = 0;
  std::uint64_t nextFault_ns_ = 0;  // not recorded before
  std::uint64_t requested_ns_ = 0;  // when the last request was granted
  std::vector<Request> due_;
};

}  // namespace haptics
