#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/servo/stiffness_limit.h"
#include "haptic_server/world/world.h"

namespace haptics {

/// Checked, for the step; errors name the field below "device".
/// @throws InvalidInput
[[nodiscard]] DeviceInfo infoOf(const World::Device& device);

[[nodiscard]] inline Vec3 vec(const World::Vector& v) noexcept { return {v[0], v[1], v[2]}; }
[[nodiscard]] inline World::Vector vectorOf(Vec3 v) noexcept { return {v.x, v.y, v.z}; }

/// A scene, the state that follows it, and the scene that is to come. One thread.
class SteppedScene {
 public:
  /// @throws InvalidInput a value out of range.
  explicit SteppedScene(const World::Device& device);

  [[nodiscard]] const StepConfig& config() const noexcept { return config_; }
  [[nodiscard]] const SurfaceLimits& limits() const noexcept { return limits_; }  ///< What the device bears.
  [[nodiscard]] const HapticState& state() const noexcept { return *state_; }
  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }  ///< The next one.

  /// Felt from the next step on.
  void publish(std::unique_ptr<ServoScene> scene);
  /// The same of a body, without allocating. Scenes that were published have a kinematic pose of each object.
  void drive(std::uint64_t body, const KinematicPose& sample) noexcept;
  void drive(std::uint64_t body, const KinematicShape& sample) noexcept;  ///< The same; of each object, too.
  void miss(std::uint64_t ticks) noexcept { tick_ += ticks; }
  [[nodiscard]] World::Sample step(const World::Vector& hip_m) noexcept;
  void run(std::span<const World::Vector> hips_m, std::span<World::Sample> samples) noexcept;

 private:
  /// Calls set(scene, index) in the scenes that have the body.
  template <class Set>
  void inScenes(std::uint64_t body, Set set) noexcept;

  StepConfig config_;
  SurfaceLimits limits_;
  std::uint64_t tick_ = 0, allowanceSpent_ = 0, depenetrated_ = 0;
  std::unique_ptr<HapticState> state_;
  std::unique_ptr<ServoScene> scene_;  // that the state has adopted
  std::unique_ptr<ServoScene> next_;   // that it is to adopt
  std::unique_ptr<ServoScene> last_;   // that it had adopted before: step() frees nothing
};

}  // namespace haptics
