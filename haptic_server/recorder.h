#pragma once

#include <fstream>
#include <string>

#include "common/error/error.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics {

/// Writes every tick's sample to a file: haptics.v1.Telemetry messages, each behind its length as a varint. For one
/// thread, not the servo's.
class Recorder {
 public:
  [[nodiscard]] static Result<Recorder> open(const std::string& file);
  void write(const TelemetrySample& sample);
  /// False when something could not be written, for instance because the disk is full.
  [[nodiscard]] bool close();

 private:
  std::ofstream out_;
  v1::Telemetry message_;
};

}  // namespace haptics
