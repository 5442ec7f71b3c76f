#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/process/file_handle.h"
#include "haptic_server/recording/recording_format.h"
#include "haptic_server/recording/scene_parts.h"
#include "haptic_server/state/record_chain.h"

namespace haptics {

/// Tells scenes, states and ticks in order as parts of a recording.
class RecordingEncoder {
 public:
  virtual ~RecordingEncoder() = default;

  /// The scene that follows the one before.
  void add(const SceneSource& scene) {
    scenes_.add(scene, [this](const v1::RecordingPart& part) { put(part); });
    scene_ = scene.number;
  }
  /// The state between the ticks added so far and the next one, of each hand.
  void add(std::span<const Keyframe> keyframes);
  /// Likewise.
  void add(std::span<const RecordedTick> tick) {
    for (std::size_t hand = 0; hand < tick.size(); ++hand) ticks_[hand].add(tick[hand]);
  }
  /// Puts what was added so far.
  void putTicks();
  /// SceneSource::number of the last one; 0: none.
  [[nodiscard]] std::uint64_t scene() const noexcept { return scene_; }

 protected:
  RecordingEncoder() = default;
  RecordingEncoder(RecordingEncoder&&) = default;
  RecordingEncoder& operator=(RecordingEncoder&&) = default;
  virtual void put(const v1::RecordingPart& part) = 0;

 private:
  /// Of a hand, not in a part yet.
  struct Ticks {
    std::string ticks;
    std::string turns;
    std::string handles;
    std::string wrenches;
    std::string grips;
    bool anyTurns = false;     // some are not as of a device without rotation
    bool anyHandles = false;   // some are not as of one that measures its pose only
    bool anyWrenches = false;  // a client added some
    bool anyGrips = false;     // some are not 0

    void add(const RecordedTick& tick);
    void moveTo(v1::RecordedTicks& message);
  };

  std::array<Ticks, kMaxHands> ticks_;
  SceneParts scenes_;
  std::uint64_t scene_ = 0;
};

/// Writes a recording, part by part; what waits for flush() is written before it takes much memory. What is written survives
/// the process; the system writes it to the disk in its own time. One thread, not the servo's.
class RecordingWriter final : public RecordingEncoder {
 public:
  /// In place of a recording that is there, whose readers keep what they read. Refused: a file that cannot be written.
  [[nodiscard]] static Result<RecordingWriter> create(const std::filesystem::path& file, const RecordingFacts& facts);

  /// A part of it as another process has encoded it.
  void addPart(std::string_view part);
  /// Refused: the disk is full, or gone. The file then ends with the last part that was written in full.
  [[nodiscard]] Result<void> flush();

 private:
  RecordingWriter(std::filesystem::path file, FileHandle handle) : file_(std::move(file)), handle_(std::move(handle)) {}
  void put(const v1::RecordingPart& part) override { addPart(part.SerializeAsString()); }
  void writePending();

  std::filesystem::path file_;
  FileHandle handle_;
  RecordWriter chain_{kRecordingHead};
  std::string pending_;  // not written yet, in records
  std::uint64_t size_ = 0;
  std::optional<Error> failure_;  // of a write
};

}  // namespace haptics
