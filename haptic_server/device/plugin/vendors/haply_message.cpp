#include "haptic_server/device/plugin/vendors/haply_message.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace haptics {
namespace {

using nlohmann::json;

/// Null where it is not there: also of what is no object.
[[nodiscard]] const json* member(const json* value, const char* name) {
  if (value == nullptr || !value->is_object()) return nullptr;
  const auto found = value->find(name);
  return found == value->end() ? nullptr : &*found;
}

template <class Value>
[[nodiscard]] bool takeNumbers(const json* value, std::initializer_list<std::pair<const char*, Value*>> numbers) {
  return std::ranges::all_of(numbers, [&](const auto& number) {
    const json* const found = member(value, number.first);
    if (found == nullptr || !found->is_number()) return false;
    *number.second = found->get<double>();
    return true;
  });
}

[[nodiscard]] bool take(const json* value, Vec3& vector) {
  return takeNumbers<double>(value, {{"x", &vector.x}, {"y", &vector.y}, {"z", &vector.z}});
}

[[nodiscard]] std::optional<bool> flag(const json* value, const char* name) {
  const json* const found = member(value, name);
  return found != nullptr && found->is_boolean() ? std::optional(found->get<bool>()) : std::nullopt;
}

/// The first of a list of devices, or the one with this name.
[[nodiscard]] const json* deviceOf(const json& message, const char* kind, std::string_view wanted) {
  const json* const list = member(&message, kind);
  if (list == nullptr || !list->is_array()) return nullptr;
  const auto found = std::ranges::find_if(*list, [&](const json& device) {
    const json* const id = member(&device, "device_id");
    return id != nullptr && id->is_string() && (wanted.empty() || id->get_ref<const std::string&>() == wanted);
  });
  return found == list->end() ? nullptr : &*found;
}

void takeGrip(const json& message, HaplyMessage& said) {
  for (const char* const kind : {"verse_grip", "wireless_verse_grip"}) {
    const json* const state = member(deviceOf(message, kind, ""), "state");
    Quat q(1, 0, 0, 0);
    if (!takeNumbers<double>(member(state, "orientation"), {{"w", &q.w}, {"x", &q.x}, {"y", &q.y}, {"z", &q.z}}))
      continue;
    said.rotation = q;
    const json* const buttons = member(state, "buttons");
    said.buttons = flag(state, "button").value_or(flag(buttons, "a").value_or(false)) ? 1 : 0;
    said.buttons |= flag(buttons, "b").value_or(false) ? 2 : 0;
    said.buttons |= flag(buttons, "c").value_or(false) ? 4 : 0;
    return;
  }
}

[[nodiscard]] json toJson(Vec3 v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }

}  // namespace

std::optional<HaplyMessage> parseHaply(std::string_view text, std::string_view wanted, std::string& reason) {
  const auto refuse = [&](const char* why) {
    reason = why;
    return std::nullopt;
  };
  const json message = json::parse(text, nullptr, false);
  if (message.is_discarded()) return refuse("its service sends what is no JSON");
  const json* const device = deviceOf(message, "inverse3", wanted);
  if (device == nullptr) return refuse("its service has no such Inverse3");
  HaplyMessage said;
  said.id = member(device, "device_id")->get<std::string>();
  const json* const state = member(device, "state");
  if (!take(member(state, "cursor_position"), said.position)) return refuse("its service tells no cursor_position");
  if (!take(member(state, "current_cursor_force"), said.appliedForce_N))
    return refuse("its service tells no current_cursor_force");
  if (Vec3 velocity(0); take(member(state, "cursor_velocity"), velocity)) said.velocity = velocity;
  const json* const status = member(device, "status");
  said.isCalibrated = flag(status, "calibrated");
  said.isPowered = flag(status, "power_supply");
  said.isInUse = flag(status, "in_use");
  takeGrip(message, said);
  return said;
}

std::string haplyCommand(std::string_view id, Vec3 force_N, HaplySpelling spelling, bool configures) {
  json device{{"device_id", id},
              {"commands",
               {{"set_cursor_force", {{spelling == HaplySpelling::kVector ? "vector" : "values", toJson(force_N)}}}}}};
  json message;
  if (configures) {
    message["session"]["configure"]["profile"]["name"] = "haptic_server";
    device["configure"] = {{"preset", {{"preset", "arm_front_centered"}}},
                           {"force_gate", {{"gain", 0.3}}},
                           {"damping", {{"scalar", 0.0}}}};
  }
  message["inverse3"] = json::array({std::move(device)});
  return message.dump();
}

}  // namespace haptics
