#pragma once

#include <cstdint>
#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/device_status.h"
#include "common/telemetry/energy_state.h"
#include "common/telemetry/handle_reading.h"

namespace haptics {

/// Values equal those of the wire's enums (telemetry.proto).
enum class PrimitiveKind : std::uint8_t { kNone = 0, kPolygon = 1, kLine = 2, kVertex = 3 };
enum class FrictionState : std::uint8_t { kNone = 0, kSticking = 1, kSliding = 2 };
enum class Fault : std::uint8_t {
  kNone = 0,
  kNonFiniteInput = 1,
  kNonFiniteForce = 2,
  kDeadlinesMissed = 3,
  kDeviceStale = 4,
  kDeviceLost = 5,
};
[[nodiscard]] constexpr FrictionState lastOf(FrictionState) noexcept { return FrictionState::kSliding; }
[[nodiscard]] constexpr Fault lastOf(Fault) noexcept { return Fault::kDeviceLost; }
enum class DeviceState : std::uint8_t { kAbsent = 0, kHoming = 1, kReady = 2, kStopped = 3 };

/// The contacted geometric primitive (paper 3.1), numbered in the mesh's canonical order. A line is (polygon, edge k:
/// corner k to corner k + 1), a vertex is (polygon, corner k).
struct PrimitiveId {
  PrimitiveKind kind = PrimitiveKind::kNone;
  std::uint8_t localIndex = 0;
  std::uint32_t polygon = 0;

  bool operator==(const PrimitiveId&) const = default;
};

/// Newtons, world frame, on the hand.
struct ForceComponents {
  Vec3 spring{0};
  Vec3 damping{0};
  Vec3 friction{0};
  Vec3 texture{0};
  Vec3 contact{0};  ///< Sum of the above, before the limits.
  Vec3 written{0};  ///< Sent to the device.
};

/// Result of one servo tick. SI units, world frame.
struct TelemetrySample {
  std::uint64_t tick = 0;
  std::uint64_t time_ns = 0;        ///< Monotonic clock when the device was read; 0 in virtual time.
  std::uint64_t sceneRevision = 0;  ///< Adopted by the servo.
  std::uint64_t adoptionTick = 0;   ///< First tick felt with sceneRevision.
  std::uint64_t deformationRevision = 0;
  Vec3 hip{0};           ///< As the device measured it.
  Vec3 predictedHip{0};  ///< Where contact and force were computed: where the HIP will be while the force is held.
  Vec3 ihip{0};
  std::uint64_t object = 0;  ///< Id of the contacted object, 0 when free.
  PrimitiveId primitive;
  double penetration_m = 0;
  Vec3 surfaceNormal{0};  ///< N_s, unit, outward; zero when free.
  FrictionState frictionState = FrictionState::kNone;
  Vec3 stickingPoint{0};
  double height_m = 0;
  ForceComponents force;
  EnergyByFeature energyGiven_J{};   ///< By all objects.
  EnergySource largestEnergySource;  ///< Of one object; 0: none gave any. Filled in for clients, not by the servo.
  Fault fault = Fault::kNone;
  double wait_s = 0;  ///< Until the force may come back, where missed ticks took it away again and again.
  DeviceState deviceState = DeviceState::kAbsent;
  DeviceStatus device;
  std::uint64_t depenetrated = 0;      ///< Times that the IHIP was found inside a body and put outside, since start.
  std::uint64_t depenetratedFrom = 0;  ///< Id of the object that the IHIP was inside of the last time.
  std::uint64_t allowanceSpent =
      0;                      ///< Ticks that left a part of the HIP's path, or bodies that collide, to the next one.
  std::uint64_t grasped = 0;  ///< Id of the object that the hand holds by a button, at ihip; 0: none.
  std::uint64_t missedTicks = 0;     ///< Since start.
  std::uint64_t droppedSamples = 0;  ///< By the queue to the network thread, since start.
  double servoRate_Hz = 0;           ///< Ticks run in the last second.
  Vec3 added_N{0};                   ///< By a client, on the hand, beside the contact's force; before the limits.
  HandleReading handle{};            ///< Of the device; not from the step.
};

static_assert(std::is_trivially_copyable_v<TelemetrySample>, "crosses threads by copy");

}  // namespace haptics
