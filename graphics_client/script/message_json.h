#pragma once

#include <google/protobuf/message.h>

#include <nlohmann/json.hpp>
#include <string>

namespace haptics {

/// A message for scripts: the wire's own field names, with every field that has a value or a default; integers as
/// numbers, bytes as hexadecimal text, enums by name, sub-messages that are absent left out.
[[nodiscard]] nlohmann::ordered_json toJson(const google::protobuf::Message& message);

/// On one line, for a terminal too: what is not ASCII is escaped, as JSON does it.
[[nodiscard]] std::string jsonText(const nlohmann::ordered_json& json);

}  // namespace haptics
