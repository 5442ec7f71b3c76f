#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "haptic_server/scene/surface_warnings.h"
#include "haptic_server/servo/flight_ring.h"
#include "haptics/v1/recording.pb.h"

// What a recording's parts say (recording.proto), between messages and the servo's own types.
namespace haptics {

inline constexpr std::string_view kRecordingHead = "haptics recording 1\n";
inline constexpr std::size_t kTickBytes = 88;    ///< Of one tick in RecordedTicks.ticks,
inline constexpr std::size_t kTurnBytes = 56;    ///< and in RecordedTicks.turns,
inline constexpr std::size_t kHandleBytes = 64;  ///< and in RecordedTicks.handles,
inline constexpr std::size_t kWrenchBytes = 48;  ///< and in RecordedTicks.wrenches,
inline constexpr std::size_t kGripBytes = 8;     ///< and in RecordedTicks.grips.

/// A hand of a recording.
struct HandFacts {
  std::string device;
  StepConfig config;
};

/// What a recording says of itself.
struct RecordingFacts {
  std::string server;
  std::string stepSources;  ///< Of the step that made the forces: SHA-256, bytes.
  std::int64_t began_unix_ns = 0;
  std::string device;
  double rate_Hz = 0;
  std::string why;
  StepConfig config;
  std::optional<HandFacts> secondHand = std::nullopt;
  DeviceLimits limits = {};      ///< By which scenes are made.
  bool isWithoutLimits = false;  ///< An old recording, whose objects say how they are felt.

  [[nodiscard]] std::size_t hands() const noexcept { return secondHand ? 2 : 1; }
};

/// SHA-256 of this program's step, 32 bytes that stay: in a source that the build writes (step_sources.cmake).
[[nodiscard]] std::string_view ownStepSources() noexcept;

[[nodiscard]] v1::RecordingHead toMessage(const RecordingFacts& facts);
/// Refused: values that no server has.
[[nodiscard]] Result<RecordingFacts> factsFrom(const v1::RecordingHead& head);

void appendTick(const RecordedTick& tick, std::string& bytes);
/// `bytes` are kTickBytes long. Refused: a device state or fault that there is not. Positions are taken as they are: the
/// step itself refuses those that are no number.
[[nodiscard]] Result<RecordedTick> tickFrom(std::string_view bytes);

/// What a tick has of rotation: false where that is nothing.
[[nodiscard]] bool turns(const RecordedTick& tick) noexcept;
void appendTurn(const RecordedTick& tick, std::string& bytes);
/// `bytes` are kTurnBytes long. Rotations are taken as they are.
void takeTurn(std::string_view bytes, RecordedTick& tick);

void appendHandle(const HandleReading& handle, std::string& bytes);
/// `bytes` are kHandleBytes long. Refused: measurements that there are not. Numbers are taken as they are.
[[nodiscard]] Result<HandleReading> handleFrom(std::string_view bytes);

void appendWrench(const Wrench& wrench, std::string& bytes);
/// `bytes` are kWrenchBytes long. Numbers are taken as they are.
[[nodiscard]] Wrench wrenchFrom(std::string_view bytes);

void appendGrip(double moment_Nm, std::string& bytes);
/// `bytes` are kGripBytes long. Numbers are taken as they are.
[[nodiscard]] double gripFrom(std::string_view bytes);

/// Bit for bit, where == would have a zero equal to one of the other sign, and no NaN to itself.
[[nodiscard]] bool sameBits(Vec3 a, Vec3 b) noexcept;
/// Likewise, of all that was written to a device.
[[nodiscard]] bool wroteSame(const RecordedTick& tick, Vec3 force_N, Vec3 torque_Nm, double grip_Nm) noexcept;

}  // namespace haptics
