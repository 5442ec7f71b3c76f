#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "haptic_server/device/plugin/device_plugin.h"
#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/device/emulated/vendors/shared_arm.h"

namespace haptics {
namespace {

using testing::HasSubstr;

/// The plug-in as the server loads it, its process, and the arm of the emulated library in that.
class OpenHaptics : public testing::Test {
 protected:
  OpenHaptics() {
    ::setenv("EMULATED_ARM", file_.c_str(), 1);
    ::setenv("LD_LIBRARY_PATH", EMULATED_VENDORS "/openhaptics", 1);
    void* const plugin = dlopen(DEVICE_PLUGINS "/openhaptics.so", RTLD_NOW | RTLD_LOCAL);
    if (plugin == nullptr) throw std::runtime_error(dlerror());
    functions_ = reinterpret_cast<const haptics_device_functions* (*)()>(dlsym(plugin, "haptics_device_plugin"))();
    arm_ = mapArm(file_.c_str());
    arm_->initialised = 1;
    turn({1, 0, 0, 0, 1, 0, 0, 0, 1});
  }
  ~OpenHaptics() override {
    if (device_ != nullptr) functions_->close(device_);
    ::unsetenv("EMULATED_ARM");
    ::unsetenv("LD_LIBRARY_PATH");
  }

  std::string open(const char* which = "") {
    const char* const reason = functions_->open(which, &device_, &info_);
    return reason == nullptr ? "" : reason;
  }
  void turn(const std::array<double, 9>& rows) {
    for (std::size_t i = 0; i < 9; ++i) arm_->rotation[i] = rows[i];
  }
  /// Writes and reads as the server does until it is so; false when it never is.
  bool until(const std::function<bool(int, const haptics_device_state&)>& isSo) {
    haptics_device_state state{};
    for (int i = 0; i < 2'000; ++i) {
      if (isSo(functions_->read(device_, 2'000'000, &state), state)) return true;
      constexpr double kNone[3]{};
      (void)functions_->write(device_, force_.data(), kNone);
    }
    return false;
  }

  const test::TemporaryFolder folder_;
  const std::string file_ = folder_ / "arm";
  const haptics_device_functions* functions_ = nullptr;
  EmulatedArm* arm_ = nullptr;
  void* device_ = nullptr;
  haptics_device_info info_{};
  std::array<double, 3> force_{};
};

// Theirs: x to the right, y up, z to the user, mm. Ours: x to the right, y away from the user, z up, m.
TEST_F(OpenHaptics, PositionsAndForcesAreInTheServersFrameAndUnitsOnEachAxis) {
  ASSERT_EQ(open(), "");
  EXPECT_STREQ(info_.name, "Touch");
  EXPECT_EQ(info_.max_force_N, 3.3);
  EXPECT_EQ(info_.degrees, 6U);
  struct Axis {
    std::array<double, 3> theirs, ours;
  };
  constexpr Axis kAxes[]{{{1, 0, 0}, {1, 0, 0}},   {{-1, 0, 0}, {-1, 0, 0}}, {{0, 1, 0}, {0, 0, 1}},
                         {{0, -1, 0}, {0, 0, -1}}, {{0, 0, 1}, {0, -1, 0}},  {{0, 0, -1}, {0, 1, 0}}};
  for (const Axis& axis : kAxes) {
    for (std::size_t i = 0; i < 3; ++i) arm_->position[i] = 32 * axis.theirs[i];
    force_ = axis.ours;
    EXPECT_TRUE(until([&](int outcome, const haptics_device_state& state) {
      bool isSo = outcome == HAPTICS_DEVICE_DONE;
      for (std::size_t i = 0; i < 3; ++i)
        isSo = isSo && state.position_m[i] == 32 * 1e-3 * axis.ours[i] && arm_->force[i] == axis.theirs[i];
      return isSo;
    })) << axis.theirs[0]
        << ' ' << axis.theirs[1] << ' ' << axis.theirs[2];
  }
}

TEST_F(OpenHaptics, VelocityIsInTheServersFrameAndUnits) {
  ASSERT_EQ(open(), "");
  for (std::size_t i = 0; i < 3; ++i) arm_->velocity[i] = 32 * static_cast<double>(i + 1);
  arm_->buttons = 0x80000005;
  EXPECT_TRUE(until([](int, const haptics_device_state& state) {
    const double* const v = state.velocity_m_per_s;
    return state.measured == HAPTICS_DEVICE_VELOCITY && v[0] == 32 * 1e-3 && v[1] == -96 * 1e-3 && v[2] == 64 * 1e-3 &&
           state.buttons == 0x80000005;
  }));
}

TEST_F(OpenHaptics, TurnsAboutEachAxisAreInTheServersFrame) {
  ASSERT_EQ(open(), "");
  const double c = std::cos(0.4), s = std::sin(0.4), half = std::cos(0.2), sine = std::sin(0.2);
  struct Turn {
    std::array<double, 9> theirs;  // by 0.4 rad about their x, y and z
    std::array<double, 4> ours;    // about our x, z and -y
  };
  const Turn kTurns[]{{{1, 0, 0, 0, c, -s, 0, s, c}, {half, sine, 0, 0}},
                      {{c, 0, s, 0, 1, 0, -s, 0, c}, {half, 0, 0, sine}},
                      {{c, -s, 0, s, c, 0, 0, 0, 1}, {half, 0, -sine, 0}}};
  for (const Turn& each : kTurns) {
    turn(each.theirs);
    EXPECT_TRUE(until([&](int, const haptics_device_state& state) {
      bool isSo = true;
      for (std::size_t i = 0; i < 4; ++i) isSo = isSo && std::abs(state.orientation[i] - each.ours[i]) < 1e-14;
      return isSo;
    }));
  }
}

TEST_F(OpenHaptics, WithoutForcesItsProcessTakesTheForceAwayByItself) {
  ASSERT_EQ(open(), "");
  force_ = {0, 0, 1};
  ASSERT_TRUE(until([&](int, const haptics_device_state&) { return arm_->force[1] == 1; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(arm_->force[1], 0);
}

TEST_F(OpenHaptics, IsCalibratedByItsInkwell) {
  arm_->initialised = 0;
  ASSERT_EQ(open(), "");
  EXPECT_TRUE(until([](int, const haptics_device_state& state) { return state.homed == 1; }));
  arm_->lost = 1;
  EXPECT_TRUE(until([](int, const haptics_device_state& state) {
    return state.homed == 0 &&
           std::string(state.condition).find("put the stylus into its inkwell") != std::string::npos;
  }));
}

TEST_F(OpenHaptics, WhatCannotBeOpenedSaysWhy) {
  EXPECT_THAT(open("Left"), HasSubstr("communication error"));
  arm_->inUse = 1;
  EXPECT_THAT(open(), HasSubstr("it is opened already"));
  ::setenv("LD_LIBRARY_PATH", "/nowhere", 1);
  EXPECT_THAT(open(), HasSubstr("libHD.so: cannot open shared object file"));
}

}  // namespace
}  // namespace haptics
