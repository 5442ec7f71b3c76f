#pragma once

#include <string_view>

#include "haptic_server/recording/recording_format.h"
#include "haptic_server/state/record_chain.h"

namespace haptics {

/// Reads a recording's parts in order, as far as they are what was written.
class RecordingReader {
 public:
  /// The bytes outlive the reader. Refused: no recording, one of another version, or damaged in its first part.
  [[nodiscard]] static Result<RecordingReader> open(std::string_view bytes);

  [[nodiscard]] const RecordingFacts& facts() const noexcept { return facts_; }
  /// The state's image is that of a state of this program.
  [[nodiscard]] bool sameLayout() const noexcept { return sameLayout_; }

  /// The next part; null at the end. Valid until the next call. Refused: the bytes are damaged from here on.
  [[nodiscard]] Result<const v1::RecordingPart*> next();
  /// Once next() has returned null: the last part was being written when the server ended.
  [[nodiscard]] bool cutOff() const noexcept { return records_.end() == LogEnd::kTorn; }
  /// Of the bytes that next() has been through, 0 to 1.
  [[nodiscard]] double share() const noexcept {
    return static_cast<double>(records_.offset()) / static_cast<double>(size_);
  }

 private:
  explicit RecordingReader(std::string_view bytes) : size_(bytes.size()), records_(bytes, kRecordingHead) {}

  std::size_t size_;
  RecordReader records_;
  v1::RecordingPart part_;
  RecordingFacts facts_;
  bool sameLayout_ = false;
};

}  // namespace haptics
