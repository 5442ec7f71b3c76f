#pragma once

#include <map>
#include <memory>

#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/fuzz/edit_run.h"

namespace haptics::eval {

/// adoptScene() and hapticStep() along a run, as the server's loop calls them. The run may grow meanwhile.
class EditDrive {
 public:
  explicit EditDrive(const EditRun& run);

  /// The next tick, with the HIP there (world, metres); publishes what the run has for it.
  const TelemetrySample& step(Vec3 hip);
  /// What the same tick would have felt without anything that was published since the last call of split().
  const TelemetrySample& stepTwin(Vec3 hip);
  void split();

  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }  ///< Of the next step().
  [[nodiscard]] const TelemetrySample& sample() const noexcept { return sample_; }
  [[nodiscard]] const HapticState& state() const noexcept { return *state_; }
  [[nodiscard]] const HapticState& twinState() const noexcept { return *twin_; }
  [[nodiscard]] const StepConfig& config() const noexcept { return config_; }
  [[nodiscard]] bool adoptedNow() const noexcept { return adoptedNow_; }  ///< In the last tick.
  [[nodiscard]] bool waiting() const noexcept { return waiting_ != nullptr; }
  /// As of the newest scene that was published; null when there is none such.
  [[nodiscard]] const FuzzObject* object(std::uint64_t id) const;

 private:
  /// What an object was made into: an edit that does not concern a part keeps it.
  struct Made {
    FuzzObject of;
    ServoObject object;
  };
  [[nodiscard]] std::shared_ptr<const ServoScene> make(const FuzzScene& scene);
  [[nodiscard]] ServoObject make(const FuzzObject& object);
  [[nodiscard]] std::shared_ptr<const CollisionMesh> surfaceOf(std::size_t mesh);
  [[nodiscard]] std::shared_ptr<const RigidBody> bodyOf(const FuzzObject& object);

  const EditRun& run_;
  StepConfig config_;
  std::unique_ptr<HapticState> state_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::map<std::uint64_t, Made> made_;
  std::shared_ptr<const ServoScene> scene_;
  std::shared_ptr<const ServoScene> waiting_;
  std::size_t published_ = 0;
  std::uint64_t number_ = 0;
  std::uint64_t tick_ = 0;
  bool adoptedNow_ = false;
  TelemetrySample sample_;

  std::unique_ptr<HapticState> twin_;
  std::shared_ptr<const ServoScene> twinScene_;
  TelemetrySample twinSample_;
};

}  // namespace haptics::eval
