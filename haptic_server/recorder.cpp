#include "haptic_server/recorder.h"

#include <google/protobuf/util/delimited_message_util.h>

#include "common/wire/convert.h"

namespace haptics {

Result<Recorder> Recorder::open(const std::string& file) {
  Recorder recorder;
  recorder.out_.open(file, std::ios::binary);
  if (!recorder.out_) return refused(file, "the recording cannot be written; the folder should exist and be writable");
  return recorder;
}

void Recorder::write(const TelemetrySample& sample, const MotionState* motion) {
  toWire(sample, message_);
  if (motion != nullptr) {
    for (const BodyState& body : motion->bodies()) toWire(body, *message_.add_body());
    for (const ObjectDent& dent : motion->dents()) toWire(dent, *message_.add_dent());
  }
  google::protobuf::util::SerializeDelimitedToOstream(message_, &out_);
}

bool Recorder::close() {
  out_.close();
  return !out_.fail();
}

}  // namespace haptics
