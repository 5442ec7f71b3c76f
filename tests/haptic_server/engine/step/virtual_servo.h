#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/step/haptic_step.h"

namespace haptics::fixture {

inline std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

inline ServoObject objectOf(std::uint64_t id, std::shared_ptr<const CollisionMesh> surface, Vec3 position,
                            double stiffness_N_per_m = 800) {
  return {id, std::move(surface), Pose{Quat(1, 0, 0, 0), position}, stiffness_N_per_m, 0.5, false};
}

inline std::unique_ptr<ServoScene> sceneOf(std::uint64_t revision, std::vector<ServoObject> objects) {
  auto scene = std::make_unique<ServoScene>();
  scene->revision = revision;
  scene->objects = std::move(objects);
  return scene;
}

/// The production step under a HIP trajectory given in advance (m, by tick), in virtual time. A copy goes on alike.
class VirtualServo {
 public:
  using Trajectory = std::function<Vec3(std::uint64_t tick)>;

  VirtualServo(Trajectory trajectory, StepConfig config, std::shared_ptr<const ServoScene> scene = nullptr)
      : trajectory_(std::move(trajectory)), config_(config), state_(config), next_(std::move(scene)) {
    tryToAdopt();
  }

  /// Now, or as soon as the contact that it would break has been let go.
  void adopt(std::shared_ptr<const ServoScene> scene) {
    next_ = std::move(scene);
    tryToAdopt();
  }
  [[nodiscard]] bool adopted() const { return next_ == nullptr; }
  TelemetrySample step() { return stepAt(trajectory_(tick_), DeviceState::kReady); }
  TelemetrySample stepAt(Vec3 position, DeviceState device) { return stepWith({position, device, {}}); }
  TelemetrySample stepWith(const DeviceReading& reading) {
    tryToAdopt();
    const StepInput input{tick_++, 0, reading};
    return hapticStep(*scene_, state_, config_, input, reading.added.acts ? &reading.added.force_N : nullptr);
  }
  TelemetrySample run(std::uint64_t ticks) {
    TelemetrySample sample;
    for (std::uint64_t i = 0; i < ticks; ++i) sample = step();
    return sample;
  }
  void skip(std::uint64_t ticks) { tick_ += ticks; }
  [[nodiscard]] std::uint64_t tick() const { return tick_; }
  [[nodiscard]] const HapticState& state() const { return state_; }

 private:
  void tryToAdopt() {
    if (next_ && adoptScene(*next_, state_, tick_)) scene_ = std::exchange(next_, nullptr);
  }

  Trajectory trajectory_;
  StepConfig config_;
  HapticState state_;
  std::shared_ptr<const ServoScene> scene_ = std::make_shared<ServoScene>();
  std::shared_ptr<const ServoScene> next_;
  std::uint64_t tick_ = 0;
};

}  // namespace haptics::fixture
