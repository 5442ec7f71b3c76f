#pragma once

#include <cstdint>
#include <vector>

#include "common/telemetry/device_reading.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics::portability {

/// A hand that goes from triangle to triangle of all objects in turn, for ever: through the air to above one, down into
/// it, holds there swaying a little, slides along it, lifts. It feels nothing; its positions are a function of the scene
/// and of where bodies that move are, without the C library's functions.
class ScriptedHand {
 public:
  static constexpr std::uint64_t kStrokeTicks = 500;

  explicit ScriptedHand(const ServoScene& scene);

  /// Where it is in this tick, of 1 ms, in metres of the world; called for one after another from 0.
  [[nodiscard]] DeviceReading at(std::uint64_t tick, const HapticState& state);

 private:
  void chooseStroke(std::uint64_t stroke, const HapticState& state);

  std::vector<const ServoObject*> objects_;
  Vec3 last_{0};
  // Of the stroke: where it began, the place on the surface, its normal and a direction along it.
  Vec3 from_{0}, place_{0}, normal_{0, 0, 1}, along_{1, 0, 0};
};

}  // namespace haptics::portability
