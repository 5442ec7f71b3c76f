#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/recording/recording_format.h"
#include "haptic_server/state/record_chain.h"

namespace haptics {

/// A recording's parts in order, after its head.
class RecordingSource {
 public:
  virtual ~RecordingSource() = default;

  [[nodiscard]] const RecordingFacts& facts() const noexcept { return facts_; }
  /// The next part; null at the end. Valid until the next call. Refused: there is none to go on with.
  [[nodiscard]] virtual Result<const v1::RecordingPart*> next() = 0;
  /// The state's image is that of a state of this program.
  [[nodiscard]] virtual bool sameLayout() const noexcept { return true; }
  /// Once next() has returned null: the last part was being written when the server ended.
  [[nodiscard]] virtual bool cutOff() const noexcept { return false; }
  /// Of the whole that next() has been through, 0 to 1.
  [[nodiscard]] virtual double share() const noexcept { return 0; }

 protected:
  explicit RecordingSource(RecordingFacts facts) : facts_(std::move(facts)) {}
  RecordingSource(RecordingSource&&) = default;
  RecordingSource& operator=(RecordingSource&&) = default;

  RecordingFacts facts_;
};

/// Reads a recording's parts in order, as far as they are what was written.
class RecordingReader final : public RecordingSource {
 public:
  /// Refused: no recording, one of another version, or damaged in its first part.
  [[nodiscard]] static Result<RecordingReader> open(RecordingBytes bytes);

  /// Refused: the bytes are damaged from here on.
  [[nodiscard]] Result<const v1::RecordingPart*> next() override;
  [[nodiscard]] bool sameLayout() const noexcept override { return sameLayout_; }
  [[nodiscard]] bool cutOff() const noexcept override { return end_ == LogEnd::kTorn; }
  [[nodiscard]] double share() const noexcept override {
    return static_cast<double>(offset_) / static_cast<double>(bytes_.size());
  }

 private:
  explicit RecordingReader(RecordingBytes bytes) : RecordingSource({}), bytes_(std::move(bytes)) {}
  [[nodiscard]] Result<std::optional<std::string_view>> nextRecord();
  [[nodiscard]] Result<std::optional<std::string_view>> endAtZeros();

  RecordingBytes bytes_;
  std::string window_;        // of them
  std::size_t offset_ = 0;    // of the next record
  std::size_t inWindow_ = 0;  // likewise, in the window
  ContentHash chain_;
  LogEnd end_ = LogEnd::kWhole;
  v1::RecordingPart part_;
  bool sameLayout_ = false;
};

}  // namespace haptics
