#include "tests/eval/replay/telemetry_file.h"

#include <google/protobuf/util/delimited_message_util.h>

#include "common/wire/convert.h"

namespace haptics::eval {

Result<TelemetryFile> TelemetryFile::open(const std::string& file) {
  TelemetryFile telemetry;
  telemetry.out_.open(file, std::ios::binary);
  if (!telemetry.out_) return refused(file, "cannot be written; the folder should exist and be writable");
  return telemetry;
}

void TelemetryFile::write(const ReplayedTick& tick) {
  toWire(tick.sample, message_);
  if (tick.secondSample != nullptr) toWireOfSecondHand(*tick.secondSample, message_);
  const MotionState* motion = tick.motion;
  if (motion != nullptr) {
    for (const BodyState& body : motion->bodies()) toWire(body, *message_.add_body());
    for (const ObjectDent& dent : motion->dents()) toWire(dent, *message_.add_dent());
  }
  google::protobuf::util::SerializeDelimitedToOstream(message_, &out_);
}

bool TelemetryFile::close() {
  out_.close();
  return !out_.fail();
}

}  // namespace haptics::eval
