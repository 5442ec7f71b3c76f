#include "haptic_server/calibration_file.h"

#include <numbers>
#include <utility>

#include "common/wire/checks.h"
#include "common/wire/convert.h"
#include "haptics/v1/device.pb.h"

namespace haptics {
namespace {

[[nodiscard]] Result<DeviceCalibration> calibrationFrom(const v1::DeviceCalibration& said, const std::string& origin) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const auto refuse = [&](Error bad) { return tl::unexpected(std::move(bad).within(origin + ": ")); };
  DeviceCalibration read;
  if (said.has_world_position()) {
    const v1::Vector3& position = said.world_position();
    if (const auto bad = checkPosition(position, "world_position")) return refuse(*bad);
    read.worldPosition = Vec3(position.x(), position.y(), position.z());
  }
  const std::tuple<bool, double, Range, const char*, std::optional<double>&> numbers[] = {
      {said.has_turn_rad(), said.turn_rad(), {-kTurn, kTurn, " rad"}, "turn_rad", read.turn_rad},
      {said.has_workspace_scale(), said.workspace_scale(), {0.1, 100}, "workspace_scale", read.workspaceScale},
      {said.has_max_force_n(), said.max_force_n(), {0, 1000, " N"}, "max_force_N", read.maxForce_N},
      {said.has_force_scale(), said.force_scale(), {0, 1}, "force_scale", read.forceScale},
      {said.has_motor_units_per_nm(),
       said.motor_units_per_nm(),
       {100, 20'000},
       "motor_units_per_Nm",
       read.motorUnitsPerNm},
  };
  for (const auto& [given, value, range, name, number] : numbers) {
    if (!given) continue;
    if (const auto bad = checkRange(value, range, name)) return refuse(*bad);
    number = value;
  }
  for (const std::uint32_t axis : said.reversed_axes()) {
    if (axis > 2) return refuse(outside("reversed_axes", axis, "give 0, 1 or 2"));
    read.reversed[axis] = true;
  }
  return read;
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
