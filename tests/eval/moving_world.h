#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/motion/rigid_body.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/body_world.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// A closed mesh, ready to be felt and to be moved.
struct MovingSolid {
  std::shared_ptr<const CollisionMesh> surface;
  RigidBody body;  ///< Of 1 kg unless asked for, without gravity.
};
[[nodiscard]] MovingSolid solidFrom(const TriMesh& mesh, double mass_kg = 1);

/// The production step on bodies that it moves by itself, under a HIP that a scene leads. SI, world frame.
class MovingWorld final : public BodyWorld {
 public:
  /// @param overlooksPut  What an edit has put into others is taken for apart.
  explicit MovingWorld(bool overlooksPut = false) : overlooksPut_(overlooksPut) {}
  std::uint64_t add(const MovingSolid& solid, const Pose& pose, bool moves = true) override;
  [[nodiscard]] ServoObject& object(std::uint64_t id) override;
  void setBody(std::uint64_t id, const RigidBody& body) { object(id).motion = std::make_shared<RigidBody>(body); }
  void setPose(std::uint64_t id, const Pose& pose);  ///< As an edit does, also to the same pose.
  void remove(std::uint64_t id);
  [[nodiscard]] const std::vector<ServoObject>& objects() const noexcept { return objects_; }

  /// What was changed is an edit, adopted with the next ticks. Removed objects stay until the contact on them has faded.
  void publish() override;
  TelemetrySample tick(Vec3 hip) override;
  /// With a second hand, which comes with the first such tick and stays.
  struct HandSamples {
    TelemetrySample first, second;
  };
  HandSamples tick(Vec3 hip, Vec3 secondHip);

  /// Null, but in tests of judges: what it makes of the answers.
  static inline void (*spoils)(TelemetrySample& sample) = nullptr;

  [[nodiscard]] const HapticState& state() const noexcept { return state_; }
  /// Its index into the state's bodies, -1 while the step does not have it.
  [[nodiscard]] int indexOf(std::uint64_t id) const noexcept;
  /// Where the step has it; it must be there.
  [[nodiscard]] const Pose& poseOf(std::uint64_t id) const override;
  [[nodiscard]] const RigidState& stateOf(std::uint64_t id) const override;
  /// How deep a point is inside one of the step's bodies, judged by all of its triangles (m); 0 outside.
  [[nodiscard]] double depthIn(std::size_t index, Vec3 point) const;
  [[nodiscard]] double energyOf(std::uint64_t id) const override;
  [[nodiscard]] std::uint64_t waitedTicks() const override { return state_.report.allowanceSpent; }

 private:
  bool overlooksPut_;
  StepConfig config_{.period_s = kPeriod_s, .maxForce_N = 1e9};
  HapticState state_{config_};
  std::unique_ptr<HapticState> second_;
  std::vector<ServoObject> objects_;
  std::vector<ServoObject> leaving_;
  std::shared_ptr<const ServoScene> scene_ = std::make_shared<ServoScene>();
  std::vector<std::shared_ptr<const ServoScene>> waiting_;  // the last is to be adopted; the state's is scene_
  std::uint64_t lastId_ = 0;
  std::uint64_t revision_ = 0;
  std::uint64_t tick_ = 0;
};

}  // namespace haptics::eval
