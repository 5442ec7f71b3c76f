#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/engine/tool/tool_contact.h"
#include "haptic_server/world/world.h"

namespace haptics {

/// A tool in the hand of a World: what it touches, and what stands between its force and the device.
class HeldTool {
 public:
  /// @throws InvalidInput a value out of range, too many points.
  HeldTool(std::shared_ptr<const CollisionMesh> surface, const World::Tool& tool, const StepConfig& config);

  /// The bodies are those of the scene from the next step on; what is felt of that comes without a step of the force.
  void adopt(const ServoScene& scene);
  /// In the next step a body goes there.
  void drive(std::uint64_t body, const Pose& pose) noexcept;
  [[nodiscard]] World::ToolSample step(const World::Pose& device) noexcept;
  [[nodiscard]] std::size_t points() const noexcept { return tool_->shell.points.size(); }

 private:
  /// Force and torque, N and Nm.
  struct Wrench {
    Vec3 force{0}, torque{0};
  };
  /// What a change that is not the hand's took from the wrench, and is given back at a bounded rate.
  struct Rest {
    Vec3 value{0};
    void shrink(double by) noexcept;
  };

  /// A body of the scene.
  struct Known {
    std::uint64_t number;
    std::shared_ptr<const CollisionMesh> surface;
    std::shared_ptr<const std::vector<Vec3>> sharp;
  };

  ToolCoupling coupling_;
  double maxForce_N_, maxTorque_Nm_, period_s_;
  Allowance allowance_;
  double spacing_m_;
  std::shared_ptr<const Tool> tool_;
  StandaloneTool contact_;
  std::vector<Body> bodies_;
  std::vector<Known> known_;  // in their order
  Wrench felt_;
  Rest force_, torque_;
  FaultRamp forceRamp_, torqueRamp_;
  bool attached_ = false;
  bool mayJump_ = false;  // for another reason than the hand
};

}  // namespace haptics
