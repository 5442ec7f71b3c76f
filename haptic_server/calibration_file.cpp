#include "haptic_server/calibration_file.h"

#include <numbers>
#include <utility>

#include "common/wire/checks.h"
#include "common/wire/convert.h"
#include "haptics/v1/device.pb.h"

namespace haptics {
namespace {

[[nodiscard]] Refusal check(const v1::DeviceCalibration& message) {
  constexpr double kTurn = 2 * std::numbers::pi;
  if (message.has_world_position()) {
    if (auto bad = checkPosition(message.world_position(), "world_position")) return bad;
  }
  const std::tuple<bool, double, Range, const char*> kNumbers[] = {
      {message.has_turn_rad(), message.turn_rad(), {-kTurn, kTurn, " rad"}, "turn_rad"},
      {message.has_workspace_scale(), message.workspace_scale(), {0.1, 100}, "workspace_scale"},
      {message.has_max_force_n(), message.max_force_n(), {0, 1000, " N"}, "max_force_N"},
      {message.has_force_scale(), message.force_scale(), {0, 1}, "force_scale"},
      {message.has_motor_units_per_nm(), message.motor_units_per_nm(), {100, 20'000}, "motor_units_per_Nm"},
  };
  for (const auto& [given, value, range, name] : kNumbers) {
    if (!given) continue;
    if (auto bad = checkRange(value, range, name)) return bad;
  }
  for (const std::uint32_t axis : message.reversed_axes()) {
    if (axis > 2) return outside("reversed_axes", axis, "give 0, 1 or 2");
  }
  return std::nullopt;
}

[[nodiscard]] Result<DeviceCalibration> calibrationFrom(const v1::DeviceCalibration& message,
                                                        const std::string& origin) {
  if (auto bad = check(message)) return tl::unexpected(std::move(*bad).within(origin + ": "));
  DeviceCalibration calibration;
  const v1::Vector3& position = message.world_position();
  if (message.has_world_position()) calibration.worldPosition = Vec3(position.x(), position.y(), position.z());
  if (message.has_turn_rad()) calibration.turn_rad = message.turn_rad();
  if (message.has_workspace_scale()) calibration.workspaceScale = message.workspace_scale();
  if (message.has_max_force_n()) calibration.maxForce_N = message.max_force_n();
  if (message.has_force_scale()) calibration.forceScale = message.force_scale();
  if (message.has_motor_units_per_nm()) calibration.motorUnitsPerNm = message.motor_units_per_nm();
  for (const std::uint32_t axis : message.reversed_axes()) calibration.reversed[axis] = true;
  return calibration;
}

}  // namespace

Result<DeviceCalibration> readCalibration(const std::string& file) {
  v1::DeviceCalibration message;
  if (auto read = readMessageFile(file, message); !read) return tl::unexpected(read.error());
  return calibrationFrom(message, file);
}

Result<DeviceCalibration> parseCalibration(const std::string& text, const std::string& origin) {
  v1::DeviceCalibration message;
  if (auto parsed = parseMessageText(text, origin, message); !parsed) return tl::unexpected(parsed.error());
  return calibrationFrom(message, origin);
}

}  // namespace haptics
