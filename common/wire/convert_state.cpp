#include <google/protobuf/descriptor.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

const google::protobuf::FieldDescriptor& stateScalar(std::string_view name) {
  return *v1::ObjectState::descriptor()->FindFieldByName(std::string(name));
}

Pose poseFrom(const v1::Pose& message) { return {rotationFrom(message.rotation()), vectorFrom(message.position())}; }

/// A value that this version does not know counts as the enum's zero.
template <class Enum>
Enum enumFrom(int value, Enum last) {
  return value < 0 || value > static_cast<int>(last) ? Enum{} : static_cast<Enum>(value);
}

PrimitiveId primitiveFrom(const v1::Primitive& message) {
  constexpr std::uint32_t kCorners = 3;
  if (message.local_index() >= kCorners) return {};
  return {enumFrom(message.kind(), PrimitiveKind::kVertex), static_cast<std::uint8_t>(message.local_index()),
          message.polygon()};
}

[[nodiscard]] std::optional<EnergyFeature> featureFrom(v1::Feature feature) {
  if (feature < v1::FEATURE_CONTACT || feature > static_cast<int>(kEnergyFeatures)) return std::nullopt;
  return static_cast<EnergyFeature>(feature - v1::FEATURE_CONTACT);
}

void takeEnergy(const v1::Telemetry& message, TelemetrySample& sample) {
  for (const v1::FeatureEnergy& energy : message.energy()) {
    const auto source = fromWire(energy);
    if (!source) continue;
    if (source->object == 0) {
      sample.energyGiven_J[static_cast<std::size_t>(source->feature)] += source->given_J;
    } else {
      sample.largestEnergySource = *source;
    }
  }
}

[[nodiscard]] HandleReading handleFrom(const v1::Telemetry& message) {
  HandleReading handle;
  if (message.has_device_velocity()) handle.measured |= HandleReading::kVelocity;
  if (message.has_device_applied_force()) handle.measured |= HandleReading::kAppliedForce;
  if (message.has_device_gripper_rad()) handle.measured |= HandleReading::kGripper;
  handle.velocity = vectorFrom(message.device_velocity());
  handle.appliedForce_N = vectorFrom(message.device_applied_force());
  handle.gripper_rad = message.device_gripper_rad();
  return handle;
}

void toWire(const HandleReading& handle, v1::Telemetry& message) {
  message.clear_device_velocity();
  message.clear_device_applied_force();
  message.clear_device_gripper_rad();
  if (handle.measured == 0) return;
  if (handle.has(HandleReading::kVelocity)) haptics::toWire(handle.velocity, *message.mutable_device_velocity());
  if (handle.has(HandleReading::kAppliedForce))
    haptics::toWire(handle.appliedForce_N, *message.mutable_device_applied_force());
  if (handle.has(HandleReading::kGripper)) message.set_device_gripper_rad(handle.gripper_rad);
}

}  // namespace

Result<ContentHash> hashFromWire(const std::string& bytes, const std::string& field) {
  if (const auto hash = ContentHash::fromBytes(bytes)) return *hash;
  return refused(field, "has " + std::to_string(bytes.size()) + " bytes; a SHA-256 hash has 32");
}

Result<AssetKind> assetKindFromWire(v1::AssetKind kind, const std::string& field) {
  switch (kind) {
    case v1::ASSET_KIND_MESH:
    case v1::ASSET_KIND_SCALAR_FIELD:
    case v1::ASSET_KIND_VERTEX_VALUES:
    case v1::ASSET_KIND_MOVED_VERTICES:
    case v1::ASSET_KIND_POINT_FIELD:
      return static_cast<AssetKind>(kind);
    default:
      return refused(field, "is " + std::to_string(kind) +
                                "; give ASSET_KIND_MESH, ASSET_KIND_SCALAR_FIELD, ASSET_KIND_VERTEX_VALUES, "
                                "ASSET_KIND_MOVED_VERTICES or ASSET_KIND_POINT_FIELD");
  }
}

const google::protobuf::FieldDescriptor& materialScalar(std::string_view name) {
  return *v1::Material::descriptor()->FindFieldByName(std::string(name));
}

Result<ObjectRecord> fromWire(const v1::ObjectState& message) {
  ObjectRecord record;
  record.id = message.id();
  if (record.id == 0) return refused("id", "is 0; ids start at 1");
  if (auto bad = checkName(message.name(), "name")) return refuse(bad);
  record.name = message.name();
  record.revision = message.revision();
  if (auto bad = take(hashFromWire(message.mesh(), "mesh"), record.mesh)) return refuse(bad);

  if (!message.pose().has_position()) return refused("pose.position", "is missing");
  if (!message.pose().has_rotation()) return refused("pose.rotation", "is missing");
  if (auto bad = checkPosition(message.pose().position(), "pose.position")) return refuse(bad);
  if (auto bad = checkRotation(message.pose().rotation(), "pose.rotation")) return refuse(bad);
  record.pose = poseFrom(message.pose());

  record.material.color = {message.color().red(), message.color().green(), message.color().blue()};
  if (auto bad = checkColor(message.color(), "color")) return refuse(bad);
  if (auto bad = take(surfaceFrom(message), record.material.surface)) return refuse(bad);
  Refusal first;
  const auto read = [&](std::string_view name, double& value) {
    value = message.GetReflection()->GetDouble(message, &stateScalar(name));
    if (!first) first = checkScalar(value, materialScalar(name), std::string(name));
  };
  forEachMaterialScalar(read, record.material);
  if (first) return refuse(first);
  if (message.has_motion()) {
    if (auto bad = take(announcedMotionFrom(message.motion()), record.motion, "motion.")) return refuse(bad);
  }
  auto deformation = announcedDeformationFrom(message.deformation());
  if (auto bad = take(std::move(deformation), record.deformation, "deformation.")) return refuse(bad);
  if (auto bad = take(announcedEffectsFrom(message.effects()), record.effects)) return refuse(bad);
  return record;
}

Result<Commit> fromWire(const v1::Commit& message) {
  Commit commit;
  commit.revision = message.revision();
  if (auto bad = take(hashFromWire(message.prev_root(), "prev_root"), commit.prevRoot)) return refuse(bad);
  if (auto bad = take(hashFromWire(message.root(), "root"), commit.root)) return refuse(bad);
  for (int i = 0; i < message.put_size(); ++i) {
    ObjectRecord& record = commit.put.emplace_back();
    if (auto bad = take(fromWire(message.put(i)), record, "put[" + std::to_string(i) + "].")) return refuse(bad);
  }
  commit.removed.assign(message.removed().begin(), message.removed().end());
  return commit;
}

void toWire(const ObjectRecord& record, v1::ObjectState& message) {
  message.set_id(record.id);
  message.set_name(record.name);
  message.set_revision(record.revision);
  message.set_mesh(record.mesh.asBytes());
  toWire(record.pose, *message.mutable_pose());
  forEachMaterialScalar(
      [&message](std::string_view name, double value) {
        message.GetReflection()->SetDouble(&message, &stateScalar(name), value);
      },
      record.material);
  message.mutable_color()->set_red(record.material.color.red);
  message.mutable_color()->set_green(record.material.color.green);
  message.mutable_color()->set_blue(record.material.color.blue);
  toWire(record.material.surface, message);
  message.clear_motion();
  if (record.motion) toWire(*record.motion, *message.mutable_motion());
  message.clear_deformation();
  if (record.deformation != DeformationProperties{}) toWire(record.deformation, *message.mutable_deformation());
  toWire(record.effects, *message.mutable_effects());
}

std::size_t wireSizeOf(const ObjectRecord& record) {
  v1::ObjectState message;
  toWire(record, message);
  return message.ByteSizeLong();
}

void toWire(const Commit& commit, v1::Commit& message) {
  message.set_revision(commit.revision);
  message.set_prev_root(commit.prevRoot.asBytes());
  message.set_root(commit.root.asBytes());
  message.clear_put();
  for (const ObjectRecord& record : commit.put) toWire(record, *message.add_put());
  message.clear_removed();
  for (const ObjectId id : commit.removed) message.add_removed(id);
}

void toWire(const EnergySource& source, v1::FeatureEnergy& message) {
  message.set_object(source.object);
  message.set_feature(static_cast<v1::Feature>(static_cast<int>(source.feature) + v1::FEATURE_CONTACT));
  message.set_energy_j(source.given_J);
}

std::optional<EnergySource> fromWire(const v1::FeatureEnergy& message) {
  const auto feature = featureFrom(message.feature());
  if (!feature) return std::nullopt;
  return EnergySource{message.object(), *feature, message.energy_j()};
}

Result<HandCommand> fromWire(const v1::HandTarget& message) {
  constexpr double kMaxPress_N = 20;
  if (auto wrong = checkPosition(message.position(), "hand_target.position")) return tl::unexpected(*std::move(wrong));
  if (auto wrong = checkRange(message.press_n(), {0, kMaxPress_N, " N"}, "hand_target.press_N")) {
    return tl::unexpected(*std::move(wrong));
  }
  HandCommand command{.leads = true, .position = vectorFrom(message.position()), .buttons = message.buttons()};
  if (message.has_rotation()) {
    if (auto wrong = checkRotation(message.rotation(), "hand_target.rotation"))
      return tl::unexpected(*std::move(wrong));
    command.rotation = normalised(rotationFrom(message.rotation()));
  }
  if (message.has_gripper_rad()) {
    constexpr double kMaxGripper_rad = 3.2;
    if (auto wrong = checkRange(message.gripper_rad(), {0, kMaxGripper_rad, " rad"}, "hand_target.gripper_rad")) {
      return tl::unexpected(*std::move(wrong));
    }
    command.gripper_rad = message.gripper_rad();
  }
  if (message.press_n() == 0) return command;
  if (auto wrong = checkUnitVector(message.normal(), "hand_target.normal")) return tl::unexpected(*std::move(wrong));
  command.normal = glm::normalize(vectorFrom(message.normal()));
  command.press_N = message.press_n();
  return command;
}

void toWire(const HandCommand& command, v1::HandTarget& message) {
  toWire(command.position, *message.mutable_position());
  toWire(command.normal, *message.mutable_normal());
  message.set_press_n(command.press_N);
  message.set_buttons(command.buttons);
  if (command.gripper_rad) message.set_gripper_rad(*command.gripper_rad);
  if (command.rotation != Quat(1, 0, 0, 0)) toWire(command.rotation, *message.mutable_rotation());
}

Result<WorkspaceCommand> fromWire(const v1::SetWorkspace& message) {
  WorkspaceCommand command;
  if (message.has_offset()) {
    if (auto wrong = checkPosition(message.offset(), "set_workspace.offset")) return tl::unexpected(*std::move(wrong));
    command.offset = vectorFrom(message.offset());
  }
  if (message.has_scale()) {
    if (auto wrong = checkRange(message.scale(), {0.1, 10}, "set_workspace.scale"))
      return tl::unexpected(*std::move(wrong));
    command.scale = message.scale();
  }
  if (message.has_rotation()) {
    if (auto wrong = checkRotation(message.rotation(), "set_workspace.rotation"))
      return tl::unexpected(*std::move(wrong));
    command.rotation = normalised(rotationFrom(message.rotation()));
  }
  if (message.has_bubble()) {
    const v1::Bubble& bubble = message.bubble();
    if (auto wrong = checkPosition(bubble.centre(), "set_workspace.bubble.centre"))
      return tl::unexpected(*std::move(wrong));
    constexpr Range kRadius{0.005, 1, " m, or 0"};
    if (bubble.radius_m() != 0) {
      if (auto wrong = checkRange(bubble.radius_m(), kRadius, "set_workspace.bubble.radius_m"))
        return tl::unexpected(*std::move(wrong));
    }
    command.bubble = Bubble{vectorFrom(bubble.centre()), bubble.radius_m()};
  }
  if (message.has_clutch_buttons()) command.clutchButtons = message.clutch_buttons();
  if (message.has_grasp_buttons()) command.graspButtons = message.grasp_buttons();
  if (message.has_mark_buttons()) command.markButtons = message.mark_buttons();
  if (message.has_next_tool_buttons()) command.nextToolButtons = message.next_tool_buttons();
  return command;
}

Result<Wrench> fromWire(const v1::AddWrench& message) {
  constexpr Range kForce{-100, 100, " N"}, kTorque{-10, 10, " Nm"};
  if (auto wrong = checkVector(message.force_n(), kForce, "add_wrench.force_N"))
    return tl::unexpected(*std::move(wrong));
  if (auto wrong = checkVector(message.torque_nm(), kTorque, "add_wrench.torque_Nm"))
    return tl::unexpected(*std::move(wrong));
  return Wrench{vectorFrom(message.force_n()), vectorFrom(message.torque_nm())};
}

TelemetrySample fromWire(const v1::Telemetry& message) {
  TelemetrySample sample;
  sample.tick = message.tick();
  sample.time_ns = message.time_ns();
  sample.sceneRevision = message.scene_revision();
  sample.adoptionTick = message.adoption_tick();
  sample.deformationRevision = message.deformation_revision();
  sample.hip = vectorFrom(message.hip());
  sample.predictedHip = message.has_predicted_hip() ? vectorFrom(message.predicted_hip()) : sample.hip;
  sample.ihip = vectorFrom(message.ihip());
  sample.object = message.object();
  sample.primitive = primitiveFrom(message.primitive());
  sample.penetration_m = message.penetration_m();
  sample.surfaceNormal = vectorFrom(message.surface_normal());
  sample.frictionState = enumFrom(message.friction_state(), FrictionState::kSliding);
  sample.stickingPoint = vectorFrom(message.sticking_point());
  sample.height_m = message.height_m();
  const v1::ForceComponents& force = message.force();
  sample.force = {vectorFrom(force.spring()),  vectorFrom(force.damping()), vectorFrom(force.friction()),
                  vectorFrom(force.texture()), vectorFrom(force.contact()), vectorFrom(force.written())};
  sample.added_N = vectorFrom(force.added());
  takeEnergy(message, sample);
  sample.fault = enumFrom(message.fault(), Fault::kDeviceLost);
  sample.deviceState = enumFrom(message.device_state(), DeviceState::kStopped);
  sample.device = {.fault = enumFrom(message.device_fault(), kLastDeviceFault),
                   .homed = !message.device_not_homed(),
                   .homedAxes = static_cast<std::uint8_t>(message.device_homed_axes()),
                   .buttons = message.device_buttons(),
                   .age_us = message.device_age_us()};
  sample.device.set(HandAction::kClutch, message.device_clutched());
  sample.device.set(HandAction::kMark, message.device_marks());
  sample.handle = handleFrom(message);
  sample.depenetrated = message.depenetrated();
  sample.depenetratedFrom = message.depenetrated_from();
  sample.allowanceSpent = message.allowance_spent();
  sample.grasped = message.grasped();
  sample.wait_s = message.wait_s();
  sample.missedTicks = message.missed_ticks();
  sample.droppedSamples = message.dropped_samples();
  sample.servoRate_Hz = message.servo_rate_hz();
  return sample;
}

void toWire(const TelemetrySample& sample, v1::Telemetry& message) {
  message.set_tick(sample.tick);
  message.set_time_ns(sample.time_ns);
  message.set_scene_revision(sample.sceneRevision);
  message.set_adoption_tick(sample.adoptionTick);
  message.set_deformation_revision(sample.deformationRevision);
  toWire(sample.hip, *message.mutable_hip());
  message.clear_predicted_hip();
  if (sample.predictedHip != sample.hip) toWire(sample.predictedHip, *message.mutable_predicted_hip());
  toWire(sample.ihip, *message.mutable_ihip());
  message.set_object(sample.object);
  message.mutable_primitive()->set_kind(static_cast<v1::PrimitiveKind>(sample.primitive.kind));
  message.mutable_primitive()->set_polygon(sample.primitive.polygon);
  message.mutable_primitive()->set_local_index(sample.primitive.localIndex);
  message.set_penetration_m(sample.penetration_m);
  toWire(sample.surfaceNormal, *message.mutable_surface_normal());
  message.set_friction_state(static_cast<v1::FrictionState>(sample.frictionState));
  toWire(sample.stickingPoint, *message.mutable_sticking_point());
  message.set_height_m(sample.height_m);
  v1::ForceComponents& force = *message.mutable_force();
  toWire(sample.force.spring, *force.mutable_spring());
  toWire(sample.force.damping, *force.mutable_damping());
  toWire(sample.force.friction, *force.mutable_friction());
  toWire(sample.force.texture, *force.mutable_texture());
  toWire(sample.force.contact, *force.mutable_contact());
  toWire(sample.force.written, *force.mutable_written());
  force.clear_added();
  if (sample.added_N != Vec3(0)) toWire(sample.added_N, *force.mutable_added());
  message.clear_energy();
  constexpr std::uint64_t kAllObjects = 0;
  for (std::size_t i = 0; i < kEnergyFeatures; ++i) {
    if (sample.energyGiven_J[i] == 0) continue;
    toWire({kAllObjects, static_cast<EnergyFeature>(i), sample.energyGiven_J[i]}, *message.add_energy());
  }
  if (sample.largestEnergySource.object != 0) toWire(sample.largestEnergySource, *message.add_energy());
  message.set_fault(static_cast<v1::Fault>(sample.fault));
  message.set_device_state(static_cast<v1::DeviceState>(sample.deviceState));
  message.set_device_fault(static_cast<v1::DeviceFault>(sample.device.fault));
  message.set_device_age_us(sample.device.age_us);
  message.set_device_buttons(sample.device.buttons);
  message.set_device_homed_axes(sample.device.homedAxes);
  message.set_device_not_homed(!sample.device.homed);
  message.set_device_clutched(sample.device.does(HandAction::kClutch));
  message.set_device_marks(sample.device.does(HandAction::kMark));
  toWire(sample.handle, message);
  message.set_depenetrated(sample.depenetrated);
  message.set_depenetrated_from(sample.depenetratedFrom);
  message.set_allowance_spent(sample.allowanceSpent);
  message.set_grasped(sample.grasped);
  message.set_wait_s(sample.wait_s);
  message.set_missed_ticks(sample.missedTicks);
  message.set_dropped_samples(sample.droppedSamples);
  message.set_servo_rate_hz(sample.servoRate_Hz);
  message.clear_body();
  message.clear_tool();
  message.clear_dent();
  message.clear_second_hand();
}

void toWireOfSecondHand(const TelemetrySample& sample, v1::Telemetry& message) {
  v1::Telemetry& second = *message.mutable_second_hand();
  toWire(sample, second);
  for (const auto clear :
       {&v1::Telemetry::clear_tick, &v1::Telemetry::clear_time_ns, &v1::Telemetry::clear_deformation_revision,
        &v1::Telemetry::clear_missed_ticks, &v1::Telemetry::clear_servo_rate_hz})
    (second.*clear)();
}

std::optional<TelemetrySample> secondHandFromWire(const v1::Telemetry& message) {
  if (!message.has_second_hand()) return std::nullopt;
  TelemetrySample sample = fromWire(message.second_hand());
  sample.tick = message.tick();
  sample.time_ns = message.time_ns();
  sample.missedTicks = message.missed_ticks();
  sample.servoRate_Hz = message.servo_rate_hz();
  return sample;
}

void toWire(const Pose& pose, v1::Pose& message) {
  toWire(pose.position, *message.mutable_position());
  toWire(pose.rotation, *message.mutable_rotation());
}

Result<Pose> poseFromWire(const v1::Pose& message, const std::string& field) {
  if (!message.has_position() || !message.has_rotation()) return refused(field, "has no position or no rotation");
  if (auto bad = checkPosition(message.position(), field + ".position")) return tl::unexpected(*std::move(bad));
  if (auto bad = checkRotation(message.rotation(), field + ".rotation")) return tl::unexpected(*std::move(bad));
  return poseFrom(message);
}

std::vector<BodyState> bodiesFromWire(const v1::Telemetry& message) {
  std::vector<BodyState> bodies;
  for (const v1::BodyPose& body : message.body()) {
    if (bodies.size() == kMaxMovingBodies) break;
    const auto pose = poseFromWire(body.pose(), "pose");
    if (body.object() == 0 || !pose) continue;
    bodies.push_back({body.object(), *pose, enumFrom(body.condition(), BodyCondition::kNonFinite)});
  }
  return bodies;
}

void toWire(const BodyState& body, v1::BodyPose& message) {
  message.set_object(body.object);
  toWire(body.pose, *message.mutable_pose());
  message.set_condition(static_cast<v1::BodyCondition>(body.condition));
}

std::optional<ToolState> toolFromWire(const v1::Telemetry& message) {
  if (message.tool().object() == 0) return std::nullopt;
  ToolState tool{.object = message.tool().object(),
                 .torque_Nm = vectorFrom(message.tool().torque_nm()),
                 .written_Nm = vectorFrom(message.tool().written_nm()),
                 .point = {}};
  bool isValid = isFinite(tool.torque_Nm) && isFinite(tool.written_Nm);
  if (message.tool().has_device_rotation()) {
    isValid = isValid && !checkRotation(message.tool().device_rotation(), "");
    tool.deviceRotation = rotationFrom(message.tool().device_rotation());
  }
  if (message.tool().has_grip()) {
    const v1::ToolGrip& grip = message.tool().grip();
    tool.grip = {grip.opening_rad(), grip.moment_nm(), grip.written_nm()};
    isValid = isValid && !checkRange(grip.opening_rad(), {0, std::numbers::pi, ""}, "") &&
              std::isfinite(grip.moment_nm()) && std::isfinite(grip.written_nm());
  }
  for (const v1::ToolPoint& point : message.tool().point()) {
    if (tool.pointCount == ToolState::kMaxPoints) break;
    const ToolState::Point& taken =
        tool.point[tool.pointCount++] = {vectorFrom(point.place()), vectorFrom(point.force_n())};
    isValid = isValid && !checkPosition(point.place(), "") && isFinite(taken.force_N);
  }
  return isValid ? std::optional(tool) : std::nullopt;
}

void toWire(const ToolState& tool, v1::ToolContact& message) {
  message.set_object(tool.object);
  toWire(tool.torque_Nm, *message.mutable_torque_nm());
  toWire(tool.written_Nm, *message.mutable_written_nm());
  toWire(tool.deviceRotation, *message.mutable_device_rotation());
  if (tool.grip) {
    message.mutable_grip()->set_opening_rad(tool.grip->opening_rad);
    message.mutable_grip()->set_moment_nm(tool.grip->moment_Nm);
    message.mutable_grip()->set_written_nm(tool.grip->written_Nm);
  }
  for (const ToolState::Point& point : tool.points()) {
    v1::ToolPoint& to = *message.add_point();
    toWire(point.place, *to.mutable_place());
    toWire(point.force_N, *to.mutable_force_n());
  }
}

std::vector<ObjectDent> dentsFromWire(const v1::Telemetry& message) {
  const auto vectorOf = [](const auto& numbers) -> std::optional<Vec3f> {
    constexpr int kNumbers = 3;
    if (numbers.size() != kNumbers) return std::nullopt;
    const Vec3f v(numbers[0], numbers[1], numbers[2]);
    if (!isFinite(Vec3(v)) || glm::any(glm::greaterThan(glm::abs(Vec3(v)), Vec3(kMaxCoordinate_m))))
      return std::nullopt;
    return v;
  };
  std::vector<ObjectDent> dents;
  for (const v1::Dent& dent : message.dent()) {
    const auto centre = vectorOf(dent.centre());
    const auto displacement = vectorOf(dent.displacement());
    if (dents.size() == kMaxDentsOfAll) break;
    if (centre && displacement) dents.push_back({dent.object(), {*centre, *displacement}});
  }
  return dents;
}

void toWire(const ObjectDent& dent, v1::Dent& message) {
  message.set_object(dent.object);
  for (int d = 0; d < 3; ++d) {
    message.add_centre(dent.dent.centre[d]);
    message.add_displacement(dent.dent.displacement[d]);
  }
}

}  // namespace haptics
