// A plug-in whose arm has the defect that WHICH names: DEFECT[,SEED[,SECONDS]], for which the hand moves it.

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>

#include "common/clock/monotonic.h"
#include "haptic_server/device/plugin/device_plugin.h"
#include "tests/haptic_server/device/emulated/defective_arm.h"

namespace {

using haptics::monotonicNow_ns;
using haptics::test::Defect;
using haptics::test::DefectiveArm;

struct Opened {
  DefectiveArm arm;
  std::uint64_t read = 0;
};

const char* open(const char* which, void** device, haptics_device_info* info) {
  std::istringstream words(which);
  std::string name, seed = "1", moves_s = "2";
  std::getline(words, name, ',');
  std::getline(words, seed, ',');
  std::getline(words, moves_s, ',');
  const auto found = std::ranges::find(haptics::test::kDefects, name);
  if (found == haptics::test::kDefects.end()) return "there is no such defect";
  auto opened = std::make_unique<Opened>(
      Opened{DefectiveArm(static_cast<Defect>(found - haptics::test::kDefects.begin()),
                          static_cast<unsigned>(std::atoi(seed.c_str())), std::atof(moves_s.c_str()))});
  *info = {};
  std::snprintf(info->name, sizeof info->name, "arm, %s", name.c_str());
  info->max_force_N = DefectiveArm::kMaxForce_N;
  info->max_rate_Hz = 1'000;
  info->max_stiffness_N_per_m = opened->arm.saidStiffness_N_per_m();
  info->resolution_m = DefectiveArm::kResolution_m;
  info->delay_s = DefectiveArm::kDelay_s;
  info->degrees = 3;
  *device = opened.release();
  return nullptr;
}

int read(void* device, std::uint64_t /*timeout_ns*/, haptics_device_state* state) {
  auto& opened = *static_cast<Opened*>(device);
  const std::uint64_t now_ns = monotonicNow_ns();
  const auto& newest = opened.arm.read(now_ns);
  if (newest.count == opened.read) return HAPTICS_DEVICE_NOTHING;
  opened.read = newest.count;
  *state = {};
  for (int k = 0; k < 3; ++k) state->position_m[k] = newest.position[k];
  state->orientation[0] = 1;
  state->homed = 1;
  state->age_us = static_cast<std::uint32_t>((now_ns - newest.measured_ns) / 1'000);
  return HAPTICS_DEVICE_DONE;
}

int write(void* device, const double force_N[3], const double /*torque_Nm*/[3]) {
  static_cast<Opened*>(device)->arm.write({force_N[0], force_N[1], force_N[2]}, monotonicNow_ns());
  return HAPTICS_DEVICE_DONE;
}

void close(void* device) { delete static_cast<Opened*>(device); }

}  // namespace

extern "C" const haptics_device_functions* haptics_device_plugin() {
  static const haptics_device_functions functions{HAPTICS_DEVICE_ABI, open, read, write, close, nullptr};
  return &functions;
}
