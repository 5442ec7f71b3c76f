#pragma once

#include <fstream>
#include <string>

#include "common/error/error.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics::eval {

/// Writes samples to a file: haptics.v1.Telemetry messages, each behind its length as a varint.
class TelemetryFile {
 public:
  [[nodiscard]] static Result<TelemetryFile> open(const std::string& file);
  /// @param motion  As of the sample's tick; null: not known for this one.
  void write(const TelemetrySample& sample, const MotionState* motion);
  /// False when something could not be written, for instance because the disk is full.
  [[nodiscard]] bool close();

 private:
  std::ofstream out_;
  v1::Telemetry message_;
};

}  // namespace haptics::eval
