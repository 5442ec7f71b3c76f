#pragma once

#include <fstream>
#include <string>

#include "common/error/error.h"
#include "haptic_server/recording/replay.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics::eval {

/// Writes samples to a file: haptics.v1.Telemetry messages, each behind its length as a varint.
class TelemetryFile {
 public:
  [[nodiscard]] static Result<TelemetryFile> open(const std::string& file);
  void write(const ReplayedTick& tick);
  /// False when something could not be written, for instance because the disk is full.
  [[nodiscard]] bool close();

 private:
  std::ofstream out_;
  v1::Telemetry message_;
};

}  // namespace haptics::eval
