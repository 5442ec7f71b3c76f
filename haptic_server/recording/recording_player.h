#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "haptic_server/device/device.h"
#include "haptic_server/recording/recorded_run.h"
#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/servo/replay_source.h"

namespace haptics {

/// How far a recording was played. The servo counts, any thread reads.
struct PlayedSoFar {
  std::atomic<std::uint64_t> ticks{0};
  std::atomic<std::uint64_t> differing{0};  ///< Ticks whose force differs from the recorded one in any bit.
  std::atomic<std::uint64_t> firstTick{0};  ///< The first differing tick, as the recorded servo counted.
  std::atomic<bool> toItsEnd{false};
};

/// A recording in place of devices and of those who edit: the servo gets the positions and buttons that each device gave
/// and the scenes that came, tick by tick, and each force is compared with the recorded one. A thread of its own reads
/// ahead of the servo and makes the scenes.
class RecordingPlayer final : public ReplaySource {
 public:
  /// Shows those who watch a scene that the servo has taken. False: it is to be shown again later.
  using Show = std::function<bool(const RemadeScene&)>;

  /// Refused: a file that cannot be read, no recording of this version.
  [[nodiscard]] static Result<std::unique_ptr<RecordingPlayer>> open(const std::filesystem::path& file);
  ~RecordingPlayer() override { finish(); }
  RecordingPlayer(const RecordingPlayer&) = delete;
  RecordingPlayer& operator=(const RecordingPlayer&) = delete;

  [[nodiscard]] const RecordingFacts& facts() const noexcept { return facts_; }
  /// Reads up to the first tick and shows the scene that it had. The store keeps what scenes are made of and outlives the
  /// player. `show` is called on the player's thread from start() on. Refused: there is no tick that could be played.
  [[nodiscard]] Result<void> prepare(AssetStore& store, Show show);
  /// After prepare(): whether this program has the step that made the recording.
  [[nodiscard]] bool sameStep() const noexcept { return run_->sameStep(); }
  [[nodiscard]] const RecordedBeginning& beginning(std::size_t hand = 0) const noexcept {
    return run_->beginnings()[hand];
  }
  void start();
  /// After the servo's last tick. Ends the thread.
  void finish();

  [[nodiscard]] const PlayedSoFar& played() const noexcept { return played_; }
  /// After finish(): how it went, for people. Refused: forces that are not the recorded ones, a damaged recording.
  [[nodiscard]] Result<std::string> verdict() const;

  /// The device of a hand that was recorded.
  [[nodiscard]] Device& device(std::size_t hand = 0) noexcept { return devices_[hand]; }

  [[nodiscard]] Next next(Tick& tick) noexcept override;
  void releaseBefore(std::uint64_t scene) noexcept override { used_.store(scene, std::memory_order_release); }

 private:
  class RecordedDevice final : public Device {
   public:
    RecordedDevice(const std::string& name, const StepConfig& config, RecordingPlayer& player, std::size_t hand);
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    /// As it was in the tick that next() gave last.
    [[nodiscard]] DeviceReading read(std::uint64_t /*tick*/) noexcept override {
      torque_Nm_ = Vec3(0);  // a tick that writes none gives none
      grip_Nm_ = 0;
      const RecordedTick& tick = player_.now_.recorded[hand_];
      return {tick.input.device, tick.handle, AddedWrench(tick.added)};
    }
    /// Compares force, torque and moment with what was written then.
    void write(Vec3 force_N) noexcept override { player_.compare(hand_, force_N, torque_Nm_, grip_Nm_); }
    void writeTorque(Vec3 torque_Nm) noexcept override { torque_Nm_ = torque_Nm; }
    void writeGrip(double moment_Nm) noexcept override { grip_Nm_ = moment_Nm; }
    void stop() noexcept override {}

   private:
    RecordingPlayer& player_;
    const std::size_t hand_;
    DeviceInfo info_;
    Vec3 torque_Nm_{0};
    double grip_Nm_ = 0;
  };
  struct ToShow {
    std::uint64_t position;  // of the tick that takes it, from 0
    std::uint64_t scene;     // ServoScene::number
  };
  /// Ticks that lie ready for the servo: 4 s at 1 kHz, in which a large mesh is built.
  static constexpr std::size_t kAhead = 4096;

  RecordingPlayer(std::filesystem::path path, RecordingBytes bytes, RecordingFacts facts);
  void compare(std::size_t hand, Vec3 force_N, Vec3 torque_Nm, double grip_Nm) noexcept;
  void run();
  void playOn();
  void readOne();
  /// \param ticks  Taken so far.
  void showTaken(std::uint64_t ticks);

  std::filesystem::path path_;
  RecordingBytes bytes_;
  RecordingFacts facts_;
  std::deque<RecordedDevice> devices_;  // of each hand
  PlayedSoFar played_;

  // The player's thread, or whoever prepares.
  std::unique_ptr<RecordedRun> run_;
  Show show_;
  std::deque<ToShow> toShow_;
  std::uint64_t read_ = 0;        // ticks
  std::optional<Error> refusal_;  // of the rest
  std::thread thread_;

  boost::lockfree::spsc_queue<RecordedRunTick, boost::lockfree::capacity<kAhead>> ahead_;
  std::atomic<bool> readAll_{false};
  std::atomic<bool> quit_{false};
  std::atomic<std::uint64_t> used_{0};

  RecordedRunTick now_;   // the servo's
  bool differs_ = false;  // likewise: a hand in this tick
};

}  // namespace haptics
