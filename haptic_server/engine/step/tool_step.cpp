#include "haptic_server/engine/step/tool_step.h"

#include <algorithm>
#include <utility>

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

}  // namespace

void attachTool(HapticState& state, const DevicePose& device) noexcept {
  ToolInHand& tool = state.tool;
  const Pose pose{device.rotation * state.objects[tool.body].scenePose.rotation, device.position};
  tool.isNew = false;
  tool.torque.reset(device.rotation);
  ToolContact(tool.memory, state.toolScratch).reset(pose, state.allBodies());
  state.toolFelt = {};
  state.place(tool.body, pose, pose);
}

void feelTool(const ServoScene& scene, HapticState& state, const StepConfig& config, const DevicePose& measured,
              ForceResult& result) noexcept {
  ToolInHand& tool = state.tool;
  if (tool.isNew) attachTool(state, measured);
  const ServoObject& object = scene.objects[tool.body];
  const Pose device{tool.torque.follow(measured.rotation) * state.objects[tool.body].scenePose.rotation,
                    state.estimate.hip};
  Allowance& allowance = result.contact.work.allowance;
  const ToolResult& felt = state.toolFelt =
      ToolContact(tool.memory, state.toolScratch)
          .follow(state.allBodies(), device, {object.stiffness_N_per_m, object.torsion_Nm_per_rad}, allowance);
  tool.torque.setTwist(felt.torque_Nm / object.torsion_Nm_per_rad, object.torsion_Nm_per_rad);
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
  if (state.limits.clutched) state.tool.torque.release();
  const bool jumps = state.now.adopted || state.now.clutchMoved || state.now.contactBroken ||
                     result.contact.work.depenetrated || result.contact.work.allowanceSpent;
  const bool faulty = state.supervision.fault != Fault::kNone;  // toolFelt is of a tick before
  const bool held = state.grasp.object != 0 || (state.features.tool && state.toolFelt.heldCount > 0);
  state.tool.torque.limit(state.supervision.ramp.gain(), faulty, jumps, held && !faulty);
}

void fadeTorque(HapticState& state, const ForceResult& result) noexcept {
  DeviceTorque& torque = state.tool.torque;
  if (torque.written_Nm() == Vec3(0)) {
    state.features.torqueFades = false;
    state.features.extras = state.hasExtras();
    return;
  }
  torque.release();
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
  bool changed = tool.torque_Nm != torque.felt_Nm() || tool.written_Nm != torque.written_Nm() ||
                 tool.deviceRotation != torque.measured() || tool.pointCount != felt.heldCount;
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
