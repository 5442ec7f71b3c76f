#pragma once

#include <google/protobuf/message.h>

#include "common/json/json.h"

namespace haptics {

/// A message for scripts: the wire's own field names, with every field that has a value or a default; integers as
/// numbers, bytes as hexadecimal text, enums by name, sub-messages that are absent left out.
[[nodiscard]] Json toJson(const google::protobuf::Message& message);

}  // namespace haptics
