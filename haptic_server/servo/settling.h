#pragma once

#include <memory>
#include <span>

#include "haptic_server/device/presets.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

// What "comes to rest" means, in virtual time: a simulated device is pushed and tapped onto a surface, and its limit cycle
// is judged. The server's limits of stiffness and `haptic_eval stability` both judge by this.
namespace haptics {

/// From a measured position to the force, tick by tick.
class ForceRenderer {
 public:
  virtual ~ForceRenderer() = default;
  /// Position (m, world), attached at the first; returns the force (N, world), within the device's limit.
  [[nodiscard]] virtual Vec3 tick(Vec3 measured) = 0;
  /// How the device is turned in the next tick(), and the torque (Nm) that came of it.
  virtual void turn(Quat /*measured*/) {}
  [[nodiscard]] virtual Vec3 torque_Nm() const { return Vec3(0); }
};

/// hapticStep() on a scene, as the server's loop calls it.
class ProductionStep final : public ForceRenderer {
 public:
  ProductionStep(ServoScene scene, const StepConfig& config);
  [[nodiscard]] Vec3 tick(Vec3 measured) override;
  void turn(Quat measured) override { rotation_ = measured; }
  [[nodiscard]] Vec3 torque_Nm() const override;

 private:
  ServoScene scene_;
  StepConfig config_;
  std::unique_ptr<HapticState> state_;
  std::uint64_t tick_ = 0;
  Quat rotation_{1, 0, 0, 0};
};

/// A device and a hand that press along -z: as they are, whatever a renderer is told of them.
struct Press {
  DevicePreset device;
  HandPreset hand;
  double period_s = 1e-3;
  double delay_s = 0;  ///< From the reading to the motor's force, beyond the hold.
  double force_N = 1;
  /// Speed at which it meets the surface, from a little above; 0: begins at rest on it, and the force is there at once.
  double tap_m_per_s = 0;
  Quat rotation{1, 0, 0, 0};  ///< In which a device that turns begins, and the hand wants it to be.
};

/// A press, and its own renderer of the surface.
struct PressTrial {
  Press press;
  std::unique_ptr<ForceRenderer> renderer;
};

/// Whether the device comes to rest in every trial: moves by no more than max(2 encoder steps, 20 um) peak to peak along its
/// worst axis in 0.3 s, beneath the encoder, before it has stopped getting quieter. Not where it is thrown 50 mm off. One that
/// turns likewise, by that way on the radius gyration_m().
/// @param place  On the surface (m, world); the way down to it is free.
[[nodiscard]] bool allComeToRest(std::span<const PressTrial> trials, Vec3 place);

/// The ways of pressing by which stability is judged: 0.5 and 1 N at once, and taps at 0.02 and 0.15 m/s.
struct PressKind {
  double force_N, tap_m_per_s;
};
[[nodiscard]] std::span<const PressKind> pressKinds() noexcept;

/// The wall by which stiffness is judged: the plane z = 0, the upper side of a cube.
struct PressedWall {
  std::shared_ptr<const CollisionMesh> surface;
  Pose pose;
  Vec3 place{0};  ///< On it.
};
[[nodiscard]] const PressedWall& pressedWall();

}  // namespace haptics
