#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_set>
#include <vector>

#include "common/error/error.h"
#include "haptic_server/recording/recording_format.h"
#include "haptic_server/scene/servo_scene_maker.h"
#include "haptic_server/state/durable_file.h"
#include "haptic_server/state/record_chain.h"

namespace haptics {

/// An object of a scene that the servo was given, as a recording keeps it: what it is made of, and what limits have made of
/// its material.
struct GivenObject {
  ServoObjectParts parts;
  double stiffness_N_per_m = 0;  ///< ServoObject's.
  double damping_Ns_per_m = 0;
  TakenDents taken = {};  ///< Likewise.

  [[nodiscard]] ObjectId id() const noexcept { return parts.record->id; }
};

struct GivenScene {
  std::uint64_t number = 0;  ///< ServoScene::number.
  std::uint64_t revision = 0;
  std::vector<GivenObject> objects;  ///< In order of id.
};

/// \param parts  What the scene is made of, object by object.
[[nodiscard]] GivenScene givenScene(const ServoScene& scene, const std::vector<ServoObjectParts>& parts);

/// Writes a recording, part by part. What flush() has written survives the process; the system writes it to the disk in its
/// own time. One thread, not the servo's.
class RecordingWriter {
 public:
  /// Refused: a file that cannot be written.
  [[nodiscard]] static Result<RecordingWriter> create(const std::filesystem::path& file, const RecordingFacts& facts);

  /// The scene that follows the one before.
  void add(const GivenScene& scene);
  void add(const Keyframe& keyframe);
  void add(const RecordedTick& tick) { appendTick(tick, ticks_); }
  /// Refused: the disk is full, or gone. The file then ends with the last flush.
  [[nodiscard]] Result<void> flush();

 private:
  RecordingWriter(std::filesystem::path file, FileHandle handle) : file_(std::move(file)), handle_(std::move(handle)) {}
  void append(const v1::RecordingPart& part);
  void addAssets(const ServoObjectParts& object);

  std::filesystem::path file_;
  FileHandle handle_;
  RecordWriter chain_{kRecordingHead};
  std::string pending_;  // not written yet, in records
  std::string ticks_;    // not in a record yet
  std::unordered_set<ContentHash> assets_;
  std::vector<GivenObject> before_;  // of the last scene added
  std::uint64_t size_ = 0;
};

}  // namespace haptics
