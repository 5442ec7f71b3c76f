#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "common/error/error.h"
#include "common/process/pending_file.h"
#include "graphics_client/export/session_sink.h"

namespace haptics {

enum class ExportFormat { kHdf5, kCsv, kMcap };

/// A file that is being written beside its name, which it takes at the end: at its name there is a whole one or none.
class ExportFile {
 public:
  /// Refused: it cannot be written, or is a folder.
  [[nodiscard]] static Result<ExportFile> open(const std::filesystem::path& file, ExportFormat format,
                                               const SessionFacts& facts);
  [[nodiscard]] SessionSink& sink() noexcept { return *sink_; }
  /// Ends the sink and gives the file its name.
  [[nodiscard]] Result<void> finish(const SessionEnd& end);

 private:
  ExportFile(PendingFile pending, std::unique_ptr<SessionSink> sink)
      : pending_(std::move(pending)), sink_(std::move(sink)) {}

  PendingFile pending_;
  std::unique_ptr<SessionSink> sink_;
};

/// @return False: the export is to end without a file.
using ExportProgress = std::function<bool(double share)>;

/// Runs the step over a recording and writes every tick. One that is damaged in the middle is written up to there, and the
/// end says why.
/// Refused: no recording with a tick, a file that cannot be written, or that was given up.
[[nodiscard]] Result<SessionEnd> exportRecording(const std::filesystem::path& recording,
                                                 const std::filesystem::path& out, ExportFormat format,
                                                 const ExportProgress& progress);

}  // namespace haptics
