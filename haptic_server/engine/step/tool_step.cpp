#include "haptic_server/engine/step/tool_step.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <utility>

#include "common/maths/rotation.h"
#include "haptic_server/engine/force/spring_damper.h"

namespace haptics {
namespace {

/// Where it is held most.
[[nodiscard]] const ToolPoint* strongestOf(const ToolResult& felt) noexcept {
  const auto end = felt.held.begin() + static_cast<std::ptrdiff_t>(felt.heldCount);
  const auto strongest = std::max_element(felt.held.begin(), end, [](const ToolPoint& a, const ToolPoint& b) {
    return squaredLength(a.force_N) < squaredLength(b.force_N);
  });
  return strongest == end ? nullptr : &*strongest;
}

[[nodiscard]] double gripperOf(const DevicePose& device) noexcept {
  return std::clamp(device.gripper_rad, 0.0, std::numbers::pi);
}

/// How far the device has the jaws open; 0 of a tool that has none.
[[nodiscard]] double openingOf(const ServoObject& object, const DevicePose& device) noexcept {
  return object.tool->jaws ? gripperOf(device) : 0;
}

[[nodiscard]] Quat asRotation(double opening_rad) noexcept { return rotationBy({opening_rad, 0, 0}); }

/// The moment on the gripper of a tool that has jaws; of one that has none, what fades of another one's.
[[gnu::noinline]] void feelGrip(ToolInHand& tool, const ServoObject& object, double opening_rad,
                                double felt_Nm) noexcept {
  static_cast<void>(tool.grip.follow(asRotation(opening_rad)));
  if (!object.tool->jaws) {
    tool.grip.release();
    if (tool.grip.written_Nm() == Vec3(0)) tool.grips = false;
    return;
  }
  tool.grip.setTwist({felt_Nm / object.grip_Nm_per_rad, 0, 0}, object.grip_Nm_per_rad);
}

}  // namespace

void attachTool(HapticState& state, const DevicePose& device) noexcept {
  ToolInHand& tool = state.tool;
  const ToolPose pose{device.rotation * state.objects[tool.body].scenePose.rotation, device.position,
                      openingOf(state.scene->objects[tool.body], device)};
  tool.isNew = false;
  tool.torque.reset(device.rotation);
  if (tool.grips) tool.grip.reset(asRotation(gripperOf(device)));
  ToolContact(tool.memory, state.toolScratch).reset(pose, state.allBodies());
  state.toolFelt = {};
  state.place(tool.body, pose, pose);
}

void feelTool(const ServoScene& scene, HapticState& state, const StepConfig& config, const DevicePose& measured,
              ForceResult& result) noexcept {
  ToolInHand& tool = state.tool;
  const ServoObject& object = scene.objects[tool.body];
  if (object.tool->jaws && !tool.grips) {
    tool.grips = true;
    tool.grip.reset(asRotation(gripperOf(measured)));
  }
  if (tool.isNew) attachTool(state, measured);
  const ToolPose device{tool.torque.follow(measured.rotation) * state.objects[tool.body].scenePose.rotation,
                        state.estimate.hip, openingOf(object, measured)};
  Allowance& allowance = result.contact.work.allowance;
  const ToolResult& felt = state.toolFelt =
      ToolContact(tool.memory, state.toolScratch)
          .follow(state.allBodies(), device,
                  {object.stiffness_N_per_m, object.torsion_Nm_per_rad, object.grip_Nm_per_rad}, allowance);
  tool.torque.setTwist(felt.torque_Nm / object.torsion_Nm_per_rad, object.torsion_Nm_per_rad);
  if (tool.grips) feelGrip(tool, object, gripperOf(measured), felt.grip_Nm);
  allowance = felt.allowance;
  const Body& own = state.bodies[tool.body];
  state.place(tool.body, Pose(own.current), felt.proxy);
  if (felt.waits) {
    result.contact.work.allowanceSpent = true;
    ++state.report.allowanceSpent;
  }

  const Vec3 stretch = own.current.position - device.position;
  const double depth = glm::length(stretch);
  const Vec3 direction = depth > 0 ? stretch / depth : Vec3(0);
  const Vec3 proxyVelocity = (own.current.position - own.previous.position) / config.period_s;
  const double approach = glm::dot(state.estimate.velocity.velocity() - proxyVelocity, direction);
  RateLimitedStiffness& stiffness = state.objects[tool.body].stiffness;
  const double byEdit_J = stiffness.follow({object.stiffness_N_per_m, object.damping_Ns_per_m}, depth, approach,
                                           config.maxForce_N, config.period_s);
  if (byEdit_J != 0) state.energy.attribute(object.id, EnergyFeature::kEdit, byEdit_J);
  const SpringDamper along = springDamper(depth, approach, stiffness.value());
  result.force.spring = along.spring * direction;
  result.force.damping = along.damping * direction;
  result.force.contact = result.force.spring + result.force.damping;
  const ToolPoint* strongest = strongestOf(felt);
  if (strongest == nullptr || !(depth > 0)) return;
  ContactResult& contact = result.contact;
  contact.touching = true;
  contact.body = static_cast<int>(strongest->body);
  contact.ihip = own.current.position;
  contact.normal = direction;
  contact.penetration_m = depth;
  contact.alongNormal = true;
  const CollisionMesh& surface = *state.bodies[strongest->body].surface;
  if (strongest->triangle != kNoTriangle)
    contact.primitive = {PrimitiveKind::kPolygon, 0, surface.canonical(strongest->triangle)};
}

void limitTorque(HapticState& state, const ForceResult& result) noexcept {
  if (state.limits.clutched) {
    state.tool.torque.release();
    state.tool.grip.release();
  }
  const bool jumps = state.now.adopted || state.now.clutchMoved || state.now.contactBroken ||
                     result.contact.work.depenetrated || result.contact.work.allowanceSpent;
  const bool faulty = state.supervision.fault != Fault::kNone;  // toolFelt is of a tick before
  const bool held = state.grasp.object != 0 || (state.features.tool && state.toolFelt.heldCount > 0);
  state.tool.torque.limit(state.supervision.ramp.gain(), faulty, jumps, held && !faulty);
  if (state.tool.grips) state.tool.grip.limit(state.supervision.ramp.gain(), faulty, jumps, held && !faulty);
}

void fadeTorque(HapticState& state, const ForceResult& result) noexcept {
  DeviceTorque& torque = state.tool.torque;
  if (torque.written_Nm() == Vec3(0) && writtenGrip_Nm(state) == 0) {
    state.features.torqueFades = false;
    state.tool.grips = false;
    state.features.extras = state.hasExtras();
    return;
  }
  torque.release();
  state.tool.grip.release();
  limitTorque(state, result);
}

Push pushOfTool(const HapticState& state, std::size_t body) noexcept {
  Push push;
  const ToolResult& felt = state.toolFelt;
  for (const ToolPoint& held : std::span(felt.held).first(felt.heldCount)) {
    if (held.body != body) continue;
    if (push.force_N == Vec3(0)) push.place_m = held.place;
    push.force_N -= held.force_N;
    push.torque_Nm -= glm::cross(held.place - push.place_m, held.force_N);
  }
  return push;
}

bool updateToolState(const HapticState& state, ToolState& tool) noexcept {
  if (!state.features.tool) return std::exchange(tool.object, 0) != 0;
  const ToolResult& felt = state.toolFelt;
  tool.object = state.objects[state.tool.body].id;
  const DeviceTorque& torque = state.tool.torque;
  std::optional<ToolState::Grip> grip;
  if (state.scene->objects[state.tool.body].tool->jaws)
    grip = {felt.proxy.opening_rad, state.tool.grip.felt_Nm().x, writtenGrip_Nm(state)};
  bool changed = grip != tool.grip || tool.torque_Nm != torque.felt_Nm() || tool.written_Nm != torque.written_Nm() ||
                 tool.deviceRotation != torque.measured() || tool.pointCount != felt.heldCount;
  tool.grip = grip;
  tool.torque_Nm = torque.felt_Nm();
  tool.written_Nm = torque.written_Nm();
  tool.deviceRotation = torque.measured();
  tool.pointCount = felt.heldCount;
  for (std::size_t i = 0; i < felt.heldCount; ++i) {
    const ToolState::Point now{felt.held[i].place, felt.held[i].force_N};
    changed = changed || !(tool.point[i] == now);
    tool.point[i] = now;
  }
  return changed;
}

}  // namespace haptics
