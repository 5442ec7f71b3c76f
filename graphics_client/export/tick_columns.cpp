#include "graphics_client/export/tick_columns.h"

#include <algorithm>
#include <array>
#include <limits>

namespace haptics {
namespace {

void put(Vec3 v, double* at) noexcept {
  at[0] = v.x;
  at[1] = v.y;
  at[2] = v.z;
}

template <Vec3 TelemetrySample::*member>
void vectorOf(const TickValues& values, double* at) {
  put(values.sample.*member, at);
}

template <Vec3 ForceComponents::*member>
void forceOf(const TickValues& values, double* at) {
  put(values.sample.force.*member, at);
}

template <Vec3 ToolState::*member>
void ofTool(const TickValues& values, double* at) {
  put(values.tool.*member, at);
}

template <double TelemetrySample::*member>
void realOf(const TickValues& values, double* at) {
  *at = values.sample.*member;
}

template <auto TelemetrySample::*member>
std::uint64_t numberOf(const TickValues& values) {
  return static_cast<std::uint64_t>(values.sample.*member);
}

void deviceRotation(const TickValues& values, double* at) {
  const Quat& q = values.tool.deviceRotation;
  at[0] = q.w;
  at[1] = q.x;
  at[2] = q.y;
  at[3] = q.z;
}

void energy(const TickValues& values, double* at) { std::ranges::copy(values.sample.energyGiven_J, at); }
static_assert(kEnergyFeatures <= TickColumn::kMaxWidth);

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

template <Vec3 HandleReading::*member, std::uint64_t bit>
void ofHandle(const TickValues& values, double* at) {
  put(values.sample.handle.has(bit) ? values.sample.handle.*member : Vec3(kNotMeasured), at);
}

template <double ToolState::Grip::*member>
void ofGrip(const TickValues& values, double* at) {
  *at = values.tool.grip ? (*values.tool.grip).*member : kNotMeasured;
}

void gripper(const TickValues& values, double* at) {
  *at = values.sample.handle.has(HandleReading::kGripper) ? values.sample.handle.gripper_rad : kNotMeasured;
}

using S = TelemetrySample;
using F = ForceComponents;
using H = HandleReading;
using G = ToolState::Grip;
constexpr std::array kColumns{
    TickColumn{"tick", "1", "", "number of the servo's cycle, since its start", 1, nullptr, numberOf<&S::tick>},
    TickColumn{"time", "ns", "", "server's monotonic clock when the device was read", 1, nullptr,
               numberOf<&S::time_ns>},
    TickColumn{"hip", "m", "world", "haptic interface point, as the device measured it", 3, vectorOf<&S::hip>},
    TickColumn{"predicted_hip", "m", "world",
               "where contact and force were computed: where the stabiliser expects the HIP while the force is held", 3,
               vectorOf<&S::predictedHip>},
    TickColumn{"ihip", "m", "world", "ideal haptic interface point; of a tool: its origin", 3, vectorOf<&S::ihip>},
    TickColumn{"force.spring", "N", "world", "on the hand: of the penetration", 3, forceOf<&F::spring>},
    TickColumn{"force.damping", "N", "world", "on the hand: of the surface's damper", 3, forceOf<&F::damping>},
    TickColumn{"force.friction", "N", "world", "on the hand: of friction", 3, forceOf<&F::friction>},
    TickColumn{"force.texture", "N", "world", "on the hand: of texture", 3, forceOf<&F::texture>},
    TickColumn{"force.contact", "N", "world", "on the hand: sum of the above, before the limits", 3,
               forceOf<&F::contact>},
    TickColumn{"force.written", "N", "world", "on the hand: as sent to the device", 3, forceOf<&F::written>},
    TickColumn{"force.added", "N", "world", "on the hand: by a client, before the limits", 3, vectorOf<&S::added_N>},
    TickColumn{"penetration", "m", "", "of the HIP, along the surface normal", 1, realOf<&S::penetration_m>},
    TickColumn{"surface_normal", "1", "world", "unit, outward; zero when free", 3, vectorOf<&S::surfaceNormal>},
    TickColumn{"sticking_point", "m", "world", "where friction sticks", 3, vectorOf<&S::stickingPoint>},
    TickColumn{"texture_height", "m", "", "of the texture at the IHIP", 1, realOf<&S::height_m>},
    TickColumn{
        "energy_given", "J", "",
        "to the hand since the servo's start, by contact, shading, friction, texture, motion, edit, a client's wrench",
        kEnergyFeatures, energy},
    TickColumn{"tool.torque", "N m", "world", "on the hand, about the tool's origin", 3, ofTool<&ToolState::torque_Nm>},
    TickColumn{"tool.torque_written", "N m", "world", "as sent to the device", 3, ofTool<&ToolState::written_Nm>},
    TickColumn{"tool.device_rotation", "1", "world", "unit quaternion w, x, y, z, as the device measured it", 4,
               deviceRotation},
    TickColumn{"tool.opening", "rad", "", "of the tool's jaws; NaN where it has none", 1, ofGrip<&G::opening_rad>},
    TickColumn{"tool.grip", "N m", "", "on the hand's gripper: above 0 it opens it; NaN likewise", 1,
               ofGrip<&G::moment_Nm>},
    TickColumn{"tool.grip_written", "N m", "", "as sent to the device; NaN likewise", 1, ofGrip<&G::written_Nm>},
    TickColumn{"device.velocity", "m/s", "world", "as the device measured it; NaN where it does not", 3,
               ofHandle<&H::velocity, H::kVelocity>},
    TickColumn{"device.applied_force", "N", "world", "on the hand: as the device says that it applies it; NaN likewise",
               3, ofHandle<&H::appliedForce_N, H::kAppliedForce>},
    TickColumn{"device.gripper", "rad", "", "opening of the device's gripper; NaN likewise", 1, gripper},
    TickColumn{"object", "1", "", "id of the touched object; 0: none", 1, nullptr, numberOf<&S::object>},
    TickColumn{"primitive.kind", "1", "", "touched primitive: 0 none, 1 polygon, 2 line, 3 vertex", 1, nullptr,
               [](const TickValues& v) { return static_cast<std::uint64_t>(v.sample.primitive.kind); }},
    TickColumn{"primitive.polygon", "1", "", "its polygon, in the mesh's canonical order", 1, nullptr,
               [](const TickValues& v) { return std::uint64_t{v.sample.primitive.polygon}; }},
    TickColumn{"primitive.index", "1", "", "its edge or corner of the polygon", 1, nullptr,
               [](const TickValues& v) { return std::uint64_t{v.sample.primitive.localIndex}; }},
    TickColumn{"friction_state", "1", "", "0 none, 1 sticking, 2 sliding", 1, nullptr, numberOf<&S::frictionState>},
    TickColumn{"fault", "1", "", "0 none; else as Fault of telemetry.proto", 1, nullptr, numberOf<&S::fault>},
    TickColumn{"device.state", "1", "", "0 absent, 1 homing, 2 ready, 3 stopped", 1, nullptr,
               numberOf<&S::deviceState>},
    TickColumn{"device.fault", "1", "", "0 none; else as DeviceFault of telemetry.proto", 1, nullptr,
               [](const TickValues& v) { return static_cast<std::uint64_t>(v.sample.device.fault); }},
    TickColumn{"device.age", "us", "", "of the position, when the servo read it", 1, nullptr,
               [](const TickValues& v) { return std::uint64_t{v.sample.device.age_us}; }},
    TickColumn{"device.buttons", "1", "", "a bit for each", 1, nullptr,
               [](const TickValues& v) { return std::uint64_t{v.sample.device.buttons}; }},
    TickColumn{"device.clutched", "1", "", "1 while the hand moves its workspace: hip stays, and there is no force", 1,
               nullptr, [](const TickValues& v) { return std::uint64_t{v.sample.device.does(HandAction::kClutch)}; }},
    TickColumn{"device.marks", "1", "", "1 while a button that marks is pressed", 1, nullptr,
               [](const TickValues& v) { return std::uint64_t{v.sample.device.does(HandAction::kMark)}; }},
    TickColumn{"scene_revision", "1", "", "of the scene that was felt", 1, nullptr, numberOf<&S::sceneRevision>},
    TickColumn{"missed_ticks", "1", "", "by the servo, since its start", 1, nullptr, numberOf<&S::missedTicks>},
    TickColumn{"allowance_spent", "1", "",
               "ticks that left a part of their work to the next one, since the servo's start", 1, nullptr,
               numberOf<&S::allowanceSpent>},
};

}  // namespace

std::span<const TickColumn> tickColumns() noexcept { return kColumns; }

}  // namespace haptics
