#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include "haptic_server/device/plugin/device_plugin.h"
#include "tests/haptic_server/device/emulated/vendors/emulated_arm.h"

namespace haptics {
namespace {

using testing::HasSubstr;
using testing::StrEq;

constexpr std::uint64_t kSoon_ns = 1'000'000;
constexpr const char* kLibrary = EMULATED_VENDORS "/sdk/lib/release/lin-x86_64-gcc/libdrd.so.3.17.5";

/// The plug-in as the server loads it, and the arm of the emulated library that it loads.
class ForceDimension : public testing::Test {
 protected:
  ForceDimension() {
    ::setenv("FDSDK", EMULATED_VENDORS "/sdk", 1);
    void* const plugin = dlopen(DEVICE_PLUGINS "/forcedimension.so", RTLD_NOW | RTLD_LOCAL);
    void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_GLOBAL);
    if (plugin == nullptr || library == nullptr) throw std::runtime_error(dlerror());
    functions_ = reinterpret_cast<const haptics_device_functions* (*)()>(dlsym(plugin, "haptics_device_plugin"))();
    arm_ = static_cast<EmulatedArm*>(reinterpret_cast<void* (*)()>(dlsym(library, "emulatedArm"))());
    arm_ = new (arm_) EmulatedArm{};
    arm_->initialised = 1;
    arm_->type = 104;
    arm_->hasWrist = arm_->hasActiveWrist = arm_->hasGripper = 1;
    arm_->gripper_rad = 0.3;
    turn({1, 0, 0, 0, 1, 0, 0, 0, 1});
  }
  ~ForceDimension() override {
    if (device_ != nullptr) functions_->close(device_);
  }

  /// Empty, or why not.
  std::string open(const char* which = "") {
    const char* const reason = functions_->open(which, &device_, &info_);
    return reason == nullptr ? "" : reason;
  }
  void turn(const std::array<double, 9>& rows) {
    for (std::size_t i = 0; i < 9; ++i) arm_->rotation[i] = rows[i];
  }
  haptics_device_state read() {
    haptics_device_state state{};
    EXPECT_EQ(functions_->read(device_, kSoon_ns, &state), HAPTICS_DEVICE_DONE);
    return state;
  }
  /// Until it has asked for the device's status again.
  haptics_device_state readLater() {
    for (int i = 0; i < 8; ++i) (void)read();
    return read();
  }
  void write(std::array<double, 3> force, std::array<double, 3> torque) {
    EXPECT_EQ(functions_->write(device_, force.data(), torque.data()), HAPTICS_DEVICE_DONE);
  }
  void writeNothingFor(int reads) {
    for (int i = 0; i < reads; ++i) {
      write({}, {});
      (void)read();
    }
  }

  const haptics_device_functions* functions_ = nullptr;
  EmulatedArm* arm_ = nullptr;
  void* device_ = nullptr;
  haptics_device_info info_{};
};

// Theirs: x to the user, y to the right, z up. Ours: x to the right, y away from the user, z up.
TEST_F(ForceDimension, PositionsAndForcesAreInTheServersFrameAndUnitsOnEachAxis) {
  ASSERT_EQ(open(), "");
  EXPECT_STREQ(info_.name, "sigma.7");
  EXPECT_EQ(info_.degrees, 6U);
  EXPECT_EQ(info_.rotation.is_driven, 1U);
  struct Axis {
    std::array<double, 3> theirs, ours;
  };
  constexpr Axis kAxes[]{{{0.01, 0, 0}, {0, -0.01, 0}},  {{-0.01, 0, 0}, {0, 0.01, 0}}, {{0, 0.02, 0}, {0.02, 0, 0}},
                         {{0, -0.02, 0}, {-0.02, 0, 0}}, {{0, 0, 0.03}, {0, 0, 0.03}},  {{0, 0, -0.03}, {0, 0, -0.03}}};
  for (const Axis& axis : kAxes) {
    for (std::size_t i = 0; i < 3; ++i) arm_->position[i] = axis.theirs[i];
    const haptics_device_state state = read();
    write(axis.ours, axis.ours);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(state.position_m[i], axis.ours[i]);
      EXPECT_EQ(arm_->force[i], axis.theirs[i]);
      EXPECT_EQ(arm_->torque[i], axis.theirs[i]);
    }
  }
}

TEST_F(ForceDimension, TurnsAboutEachAxisAreInTheServersFrame) {
  ASSERT_EQ(open(), "");
  const double c = std::cos(0.4), s = std::sin(0.4), half = std::cos(0.2), sine = std::sin(0.2);
  struct Turn {
    std::array<double, 9> theirs;  // by 0.4 rad about their x, y and z
    std::array<double, 4> ours;    // about our -y, x and z
  };
  const Turn kTurns[]{{{1, 0, 0, 0, c, -s, 0, s, c}, {half, 0, -sine, 0}},
                      {{c, 0, s, 0, 1, 0, -s, 0, c}, {half, sine, 0, 0}},
                      {{c, -s, 0, s, c, 0, 0, 0, 1}, {half, 0, 0, sine}}};
  for (const Turn& each : kTurns) {
    turn(each.theirs);
    const haptics_device_state state = read();
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(state.orientation[i], each.ours[i], 1e-15);
  }
}

TEST_F(ForceDimension, AnOrientationThatIsNoneIsNotMadeOne) {
  ASSERT_EQ(open(), "");
  turn({0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5});
  const haptics_device_state state = read();
  double squared = 0;
  for (const double q : state.orientation) squared += q * q;
  EXPECT_GT(std::abs(squared - 1), 0.1);
}

TEST_F(ForceDimension, ItsWatchdogIsSetTo25MillisecondsAndItsMotorsAreSwitchedOn) {
  ASSERT_EQ(open(), "");
  EXPECT_EQ(arm_->watchdog_ns, 25'000'000U);
  EXPECT_EQ(arm_->forceOn, 1U);
  functions_->close(device_);
  device_ = nullptr;
  EXPECT_EQ(arm_->forceOn, 0U);
}

TEST_F(ForceDimension, MovesByItselfOnlyWhereThatIsAllowed) {
  arm_->initialised = 0;
  EXPECT_THAT(open(), HasSubstr("sigma.7 is not initialised, for which it moves by itself"));
  EXPECT_EQ(arm_->movesByItself, 0U);
  ASSERT_EQ(open("0,move"), "");
  EXPECT_EQ(arm_->movesByItself, 1U);
}

TEST_F(ForceDimension, WhatCannotBeOpenedSaysWhy) {
  EXPECT_THAT(open("3"), HasSubstr("no device found"));
  EXPECT_THAT(open("left"), HasSubstr("its number is wanted"));
  EXPECT_THAT(open("3move"), HasSubstr("its number is wanted"));
  arm_->inUse = 1;
  EXPECT_THAT(open(), HasSubstr("device already in use"));
}

TEST_F(ForceDimension, AForceThatTheDeviceTookAwayIsNamedAndComesBackOnceNoneIsAskedFor) {
  ASSERT_EQ(open(), "");
  for (const auto& [cause, words] : {std::pair{2U, "limit of velocity"},
                                     {3U, "its watchdog got no force for 25 ms"},
                                     {4U, "a program switched it off"},
                                     {5U, "USB connection was lost"}}) {
    write({0, 0, 1}, {});
    arm_->forceOffCause = cause;
    arm_->forceOn = 0;
    const haptics_device_state state = readLater();
    EXPECT_EQ(state.force_off, 1U);
    EXPECT_THAT(state.condition, HasSubstr(words));
    write({0, 0, 1}, {});
    EXPECT_EQ(arm_->forceOn, 0U) << "not while a force is asked for";
    writeNothingFor(150);
    EXPECT_EQ(arm_->forceOn, 1U);
    EXPECT_EQ(readLater().force_off, 0U);
  }
}

TEST_F(ForceDimension, WhatAPersonsSwitchTookAwayComesBackByThatSwitchOnly) {
  ASSERT_EQ(open(), "");
  for (const auto& [cause, words] : {std::pair{1U, "its force button was pressed"}, {6U, "dead man's switch"}}) {
    arm_->forceOffCause = cause;
    arm_->forceOn = 0;
    EXPECT_THAT(readLater().condition, HasSubstr(words));
    writeNothingFor(150);
    EXPECT_EQ(arm_->forceOn, 0U);
    arm_->forceOn = 1;
    EXPECT_EQ(readLater().force_off, 0U);
  }
}

TEST_F(ForceDimension, OldDataIsNoPositionAndALostConnectionIsGone) {
  ASSERT_EQ(open(), "");
  haptics_device_state state{};
  arm_->timeGuard = 1;
  EXPECT_EQ(functions_->read(device_, kSoon_ns, &state), HAPTICS_DEVICE_NOTHING);
  arm_->timeGuard = 0;
  arm_->communication = 1;
  EXPECT_EQ(functions_->read(device_, kSoon_ns, &state), -1);
  EXPECT_THAT(state.condition, StrEq("communication error"));
  int outcome = 0;
  for (int i = 0; i < 1'000 && outcome != HAPTICS_DEVICE_GONE; ++i)
    outcome = functions_->read(device_, kSoon_ns, &state);
  EXPECT_EQ(outcome, HAPTICS_DEVICE_GONE);
  arm_->communication = 0;
  arm_->unplugged = 1;
  EXPECT_EQ(functions_->read(device_, kSoon_ns, &state), HAPTICS_DEVICE_GONE);
}

TEST_F(ForceDimension, LostInitialisationAndSaturatedMotorsAreTold) {
  ASSERT_EQ(open(), "");
  EXPECT_EQ(readLater().homed, 1U);
  arm_->lost = 1;
  EXPECT_EQ(readLater().homed, 0U);
  arm_->lost = 0;
  arm_->saturated = 1;
  write({0, 0, 12}, {});
  EXPECT_THAT(readLater().condition, HasSubstr("saturated"));
}

TEST_F(ForceDimension, AClosedGripperIsTheLastButtonWhicheverHandHoldsIt) {
  ASSERT_EQ(open(), "");
  arm_->buttons = 0x80000185;
  EXPECT_EQ(read().buttons, 0x185U);
  for (const double side : {1.0, -1.0}) {
    arm_->gripper_rad = side * 0.04;
    EXPECT_EQ(read().buttons, 0x80000185U);
    EXPECT_EQ(read().gripper_rad, 0.04);
    arm_->gripper_rad = side * 0.08;
    EXPECT_EQ(read().buttons, 0x80000185U) << "it does not flicker";
    arm_->gripper_rad = side * 0.2;
    EXPECT_EQ(read().buttons, 0x185U);
  }
}

// Theirs: x to the user, y to the user's right, z up.
TEST_F(ForceDimension, VelocityIsInTheServersFrameAndTheGripperIsToldWhereThereIsOne) {
  for (const bool hasGripper : {true, false}) {
    arm_->hasGripper = hasGripper;
    ASSERT_EQ(open(), "");
    for (std::size_t i = 0; i < 3; ++i) arm_->velocity[i] = 0.1 * static_cast<double>(i + 1);
    const haptics_device_state state = read();
    EXPECT_EQ(state.measured,
              static_cast<unsigned>(HAPTICS_DEVICE_VELOCITY | (hasGripper ? HAPTICS_DEVICE_GRIPPER : 0)));
    EXPECT_THAT(state.velocity_m_per_s, testing::ElementsAre(0.2, -0.1, 0.1 * 3));
    EXPECT_EQ(state.gripper_rad, hasGripper ? 0.3 : 0);
    functions_->close(std::exchange(device_, nullptr));
  }
}

// 8 N on a lever of 50 mm.
TEST_F(ForceDimension, TheGripperTakesItsMomentAsAForceWithTheOthersWhereItIsKnownToHaveAMotor) {
  ASSERT_EQ(open(), "");
  EXPECT_EQ(info_.max_gripper_Nm, 0.4);
  EXPECT_EQ(info_.max_gripper_Nm_per_rad, 1);
  const double force[]{0, 0, 3}, torque[]{0, 0, 0.1};
  EXPECT_EQ(functions_->write_gripper(device_, force, torque, 0.2), HAPTICS_DEVICE_DONE);
  EXPECT_EQ(arm_->gripperForce, 4);
  EXPECT_EQ(arm_->force[2], 3);
  EXPECT_EQ(arm_->torque[2], 0.1);
  functions_->close(std::exchange(device_, nullptr));
  EXPECT_EQ(arm_->gripperForce, 0) << "after the end";
  for (const std::uint32_t type : {34, 108, 999}) {
    arm_->type = type;
    ASSERT_EQ(open(), "");
    EXPECT_EQ(info_.max_gripper_Nm, 0) << type;
    functions_->close(std::exchange(device_, nullptr));
  }
}

}  // namespace
}  // namespace haptics
