#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "haptic_server/device/plugin/plugin_link.h"

namespace haptics::test::plugin_protocol_test {
namespace {

constexpr haptics_device_info kTurning{.name = "test",
                                       .max_force_N = 5,
                                       .max_rate_Hz = 1000,
                                       .degrees = 6,
                                       .rotation = {.is_driven = 1, .max_torque_Nm = 1},
                                       .max_gripper_Nm = 0.4,
                                       .max_gripper_Nm_per_rad = 1};

/// The position and rotation of a state, and what is written for a force and a torque, with these axes reversed.
struct Reversed {
  PluginProtocol protocol;

  explicit Reversed(std::array<bool, 3> axes) : protocol(kTurning, {.reversed = axes}) {}
  void take(Vec3 position, Quat q) {
    const haptics_device_state state{.position_m = {position.x, position.y, position.z},
                                     .orientation = {q.w, q.x, q.y, q.z}};
    std::array<std::uint8_t, sizeof state> bytes;
    std::memcpy(bytes.data(), &state, sizeof state);
    EXPECT_FALSE(protocol.take(bytes, [&](const DeviceReply& reply) { at = protocol.locate(reply).value(); }));
  }
  std::array<double, 6> written(Vec3 force, Vec3 torque) {
    protocol.setTorque(torque, 0);
    std::array<double, 6> output;
    std::memcpy(output.data(), protocol.command(force, DeviceLight::kReady).data(), sizeof output);
    return output;
  }
  Vec3 at{0};
};

// What a mirror shows of a turn: about the axis across it, the same one; about those in it, the other way.
TEST(PluginProtocol, AReversedAxisMirrorsPositionsTurnsForcesAndTorques) {
  Reversed mirrored({false, false, true});
  mirrored.take({0.01, 0.02, 0.03}, {0.8, 0.6, 0, 0});
  EXPECT_EQ(mirrored.at, Vec3(0.01, 0.02, -0.03));
  EXPECT_EQ(mirrored.protocol.rotation(), Quat(0.8, -0.6, 0, 0));
  mirrored.take({}, {0.8, 0, 0, 0.6});
  EXPECT_EQ(mirrored.protocol.rotation(), Quat(0.8, 0, 0, 0.6));
  EXPECT_EQ(mirrored.written({1, 2, 3}, {0.1, 0.2, 0.3}), (std::array<double, 6>{1, 2, -3, -0.1, -0.2, 0.3}));
}

TEST(PluginProtocol, TwoReversedAxesAreATurnOfTheDevice) {
  Reversed turned({true, true, false});
  turned.take({0.01, 0.02, 0.03}, {0.8, 0.6, 0, 0});
  EXPECT_EQ(turned.at, Vec3(-0.01, -0.02, 0.03));
  EXPECT_EQ(turned.protocol.rotation(), Quat(0.8, -0.6, 0, 0));
  EXPECT_EQ(turned.written({1, 2, 3}, {0.1, 0.2, 0.3}), (std::array<double, 6>{-1, -2, 3, -0.1, -0.2, 0.3}));
}

TEST(PluginProtocol, TheGrippersMomentIsScaledAndBoundedAndNothingWhereItIsNotFinite) {
  PluginProtocol protocol(kTurning, {.forceScale = 0.5, .reversed = {true, false, false}});
  for (const auto& [asked_Nm, written_Nm] : {std::pair(0.2, 0.1), std::pair(-0.2, -0.1), std::pair(3.0, 0.2),
                                             std::pair(std::numeric_limits<double>::quiet_NaN(), 0.0)}) {
    protocol.setTorque(Vec3(0), asked_Nm);
    std::array<double, 7> output;
    std::memcpy(output.data(), protocol.command(Vec3(0), DeviceLight::kReady).data(), sizeof output);
    EXPECT_EQ(output[6], written_Nm);
  }
}

}  // namespace
}  // namespace haptics::test::plugin_protocol_test
