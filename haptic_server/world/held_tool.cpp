#include "haptic_server/world/held_tool.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/world/input_checks.h"
#include "haptic_server/world/stepped_scene.h"

namespace haptics {
namespace {

constexpr double kMaxHoldStiffness_N_per_m = 1e5, kMaxTorsion_Nm_per_rad = 1e3, kMaxTorque_Nm = 100;
/// Of a fault's end, as the server's devices.
constexpr double kRise_s = 0.5;

[[nodiscard]] std::shared_ptr<const Tool> makeTool(std::shared_ptr<const CollisionMesh> surface,
                                                   const World::Tool& tool) {
  auto shell = makeToolShell(*surface, tool.spacing_m);
  if (!shell) refuse("tool." + shell.error().field, shell.error().reason);
  return std::make_shared<const Tool>(Tool{std::move(surface), *std::move(shell)});
}

[[nodiscard]] bool isPose(const World::Pose& pose) noexcept {
  const auto& [w, x, y, z] = pose.rotation;
  const double squared = w * w + x * x + y * y + z * z;
  return isWithinWorld(vec(pose.position_m)) && squared > 0.5 && squared < 2;  // not for NaN
}

}  // namespace

void HeldTool::Rest::shrink(double by) noexcept {
  const double length = glm::length(value);
  value = length > by ? value * (1 - by / length) : Vec3(0);
}

HeldTool::HeldTool(std::shared_ptr<const CollisionMesh> surface, const World::Tool& tool, const StepConfig& config)
    : coupling_{tool.stiffness_N_per_m, tool.torsion_Nm_per_rad},
      maxForce_N_(config.maxForce_N),
      maxTorque_Nm_(tool.maxTorque_Nm),
      period_s_(config.period_s),
      allowance_(config.allowance()),
      spacing_m_(tool.spacing_m),
      tool_(makeTool(std::move(surface), tool)) {
  contact_.hold(*tool_);
  check(tool.stiffness_N_per_m, ToolCoupling::kMin, kMaxHoldStiffness_N_per_m, " N/m", "tool.stiffness_N_per_m");
  check(tool.torsion_Nm_per_rad, ToolCoupling::kMin, kMaxTorsion_Nm_per_rad, " Nm/rad", "tool.torsion_Nm_per_rad");
  check(tool.maxTorque_Nm, ToolCoupling::kMin, kMaxTorque_Nm, " Nm, what the device bears", "tool.maxTorque_Nm");
}

void HeldTool::adopt(const ServoScene& scene) {
  std::vector<ToolContact::Obstacle> obstacles;
  std::vector<Known> known;
  const std::vector<Body> bodiesBefore = std::exchange(bodies_, {});
  bool isChanged = false;  // where the tool may touch something, by more than a motion
  std::size_t kept = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ServoObject& object = scene.objects[i];
    if (object.pendingRemoval) continue;
    const auto before = std::ranges::find(known_, object.id, &Known::number);
    const bool isKnown = before != known_.end();
    known.push_back({object.id, object.surface,
                     isKnown ? before->sharp
                             : std::make_shared<const std::vector<Vec3>>(
                                   sharpPoints(*object.surface, spacing_m_, kMaxToolPoints))});
    Body& body = bodies_.emplace_back();
    body.surface = object.surface.get();
    const bool isDriven = scene.kinematic[i].number != 0;
    const Body* was = isKnown ? &bodiesBefore[static_cast<std::size_t>(before - known_.begin())] : nullptr;
    body.current = isDriven ? scene.kinematic[i].pose : object.pose;
    // A motion that no step has felt yet remains one.
    body.previous = was != nullptr && isDriven ? was->previous : body.current;
    body.update();
    kept += isKnown ? 1 : 0;
    isChanged =
        isChanged || was == nullptr || was->surface != body.surface || (!isDriven && was->current != body.current);
    obstacles.push_back({body.previous, *known.back().sharp, isKnown ? static_cast<int>(before - known_.begin()) : -1});
  }
  contact_.adopt(obstacles);
  mayJump_ = mayJump_ || isChanged || kept < known_.size();
  known_ = std::move(known);
}

void HeldTool::drive(std::uint64_t body, const Pose& pose) noexcept {
  const auto known = std::ranges::find(known_, body, &Known::number);
  if (known == known_.end()) return;
  Body& moved = bodies_[static_cast<std::size_t>(known - known_.begin())];
  moved.current = pose;
  moved.update();
}

World::ToolSample HeldTool::step(const World::Pose& device) noexcept {
  const bool faulty = !isPose(device);
  World::ToolSample sample;
  Wrench wrench = felt_;
  if (!faulty) {
    const auto& [w, x, y, z] = device.rotation;
    const Pose pose{glm::normalize(Quat(w, x, y, z)), vec(device.position_m)};
    if (!attached_) {
      contact_.reset(pose, bodies_);
      forceRamp_.begin(kRise_s);
      torqueRamp_.begin(kRise_s);
      felt_ = {};
      force_ = torque_ = {};
      attached_ = true;
    }
    const ToolResult result = contact_.follow(bodies_, pose, coupling_, allowance_);
    for (Body& body : bodies_) {
      if (!body.moving) continue;
      body.previous = body.current;
      body.update();
    }
    wrench = {limitMagnitude(result.force_N, maxForce_N_), limitMagnitude(result.torque_Nm, maxTorque_Nm_)};
    if (mayJump_) {
      force_.value += felt_.force - wrench.force;
      torque_.value += felt_.torque - wrench.torque;
    }
    mayJump_ = result.waits;
    felt_ = wrench;
    const double rate_N = EditSlew::kRate_N_per_s * period_s_;
    force_.shrink(rate_N);
    torque_.shrink(rate_N * tool_->shell.radius_m);
    sample.touching = static_cast<std::uint32_t>(contact_.touching());
    sample.waits = result.waits;
  } else {
    sample.fault = World::Fault::kNonFiniteHip;
  }
  sample.force_N =
      vectorOf(limitMagnitude(forceRamp_.apply(faulty, wrench.force + force_.value, period_s_), maxForce_N_));
  sample.torque_Nm =
      vectorOf(limitMagnitude(torqueRamp_.apply(faulty, wrench.torque + torque_.value, period_s_), maxTorque_Nm_));
  if (faulty && forceRamp_.atZero()) attached_ = false;
  const Pose& proxy = contact_.proxy();
  sample.proxy = {vectorOf(proxy.position), {proxy.rotation.w, proxy.rotation.x, proxy.rotation.y, proxy.rotation.z}};
  return sample;
}

}  // namespace haptics
