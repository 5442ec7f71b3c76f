#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "common/process/shared_memory.h"
#include "haptic_server/recording/recording_format.h"
#include "haptic_server/recording/scene_parts.h"

namespace haptics {

/// What a recording of the last seconds needs beside the flight ring, in memory that outlives the process where another one
/// has it too: what the recording is of, and the scenes that the servo may have used. One thread.
class SceneJournal {
 public:
  /// Refused: the system has no more memory.
  [[nodiscard]] static Result<SceneJournal> make(const RecordingFacts& facts);

  /// The scene that follows the one before. Refused, and as before: there is no memory for it.
  [[nodiscard]] Result<void> add(const SceneSource& scene);
  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }  ///< Bytes.
  [[nodiscard]] int descriptor() const noexcept { return file_.descriptor(); }

 private:
  explicit SceneJournal(FileHandle file) : file_(std::move(file)) {}
  [[nodiscard]] Result<void> append(std::string_view bytes);

  FileHandle file_;
  SceneParts parts_;
  std::uint64_t size_ = 0;
};

/// A journal as another process left it, wherever that was killed.
class SceneJournalReader {
 public:
  /// @param descriptor  Of its memory. Refused: it does not begin as a journal does.
  [[nodiscard]] static Result<SceneJournalReader> open(int descriptor);
  [[nodiscard]] const RecordingFacts& facts() const noexcept { return facts_; }
  /// Each part that is whole, for RecordingWriter::addPart().
  void forEach(const std::function<void(std::string_view part)>& visit) const;

 private:
  SceneJournalReader(SharedMemory memory, std::string_view scenes, RecordingFacts facts)
      : memory_(std::move(memory)), scenes_(scenes), facts_(std::move(facts)) {}

  SharedMemory memory_;
  std::string_view scenes_;
  RecordingFacts facts_;
};

}  // namespace haptics
