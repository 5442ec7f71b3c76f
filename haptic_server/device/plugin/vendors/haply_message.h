#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/maths/vec.h"

namespace haptics {

/// How the service spells the force of a command: its pages say "vector", some of its clients "values".
enum class HaplySpelling { kVector, kValues };

/// What a message of Haply's service says of one Inverse3 and of the first grip. Its frame is the server's: x to the right, y
/// forward, z up; m, m/s, N.
struct HaplyMessage {
  std::string id;
  Vec3 position{0};
  Vec3 appliedForce_N{0};
  std::optional<Vec3> velocity;  ///< Where it is told.
  std::optional<Quat> rotation;  ///< Of the grip, where there is one; not checked to be a rotation.
  std::uint32_t buttons = 0;
  // Where the message has a status; as the last one said elsewhere.
  std::optional<bool> isCalibrated, isPowered, isInUse;
};

/// The device called `wanted`, or the first one where that is empty. None, and `reason` says why, where the text is not JSON, has
/// no such device, or lacks one of the numbers. Untrusted: whatever it is.
[[nodiscard]] std::optional<HaplyMessage> parseHaply(std::string_view text, std::string_view wanted,
                                                     std::string& reason);

/// One message with a force, which lasts for one tick of the service. With `configures`, also who is speaking, an origin in the middle of
/// the workspace, and the force gate and damping that are its defaults, whatever the last program left behind.
[[nodiscard]] std::string haplyCommand(std::string_view id, Vec3 force_N, HaplySpelling spelling, bool configures);

}  // namespace haptics
