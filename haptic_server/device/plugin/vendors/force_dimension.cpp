// --device forcedimension[:WHICH]: Force Dimension's omega, delta, sigma and lambda, and the Novint Falcon, through the maker's
// library. force_dimension.md, beside this file, says how it is used.
//
// Frame: theirs has x to the user, y to the user's right, z up (as CHAI3D's driver has it); ours x to the right, y away, z up.
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/maths/vec.h"
#include "haptic_server/device/plugin/device_plugin.h"
#include "haptic_server/device/plugin/vendors/dhd.h"

namespace haptics {
namespace {

/// Of 125 us each: 25 ms, after which the device's own firmware takes the force away.
constexpr unsigned char kWatchdogPeriods = 200;
/// A position is read once a cycle of the server, so long before its end: it is there, and fresh, for the tick that follows.
constexpr std::uint64_t kBeforeEnd_ns = 350'000, kBetweenReads_ns = 400'000;
constexpr std::uint64_t kBetweenStatus_ns = 2'000'000;
/// Calls that fail for so long in a row: it is gone, and opened anew.
constexpr std::uint64_t kGoneAfter_ns = 100'000'000;
/// Motors that the device switched off come on again once no force was asked for during so long.
constexpr std::uint64_t kRest_ns = 50'000'000;
/// For so long after the last time, the saturation of motors is still reported.
constexpr std::uint64_t kTellFor_ns = 1'000'000'000;
/// The gripper is a button too, the last one: closed below the one angle, open above the other.
constexpr double kClosed_rad = 0.05, kOpen_rad = 0.1;
constexpr std::uint32_t kGripperButton = 1U << 31;

/// Force, stiffness and damping limit, resolution, and mass and friction as in haptic_server/device/presets.cpp, which says
/// what of them is assumed; torque and torsion limit, resolution of turns, and force of the gripper. 0 is not known.
struct Model {
  int type;
  double maxForce_N, stiffness_N_per_m, damping_Ns_per_m, resolution_m, mass_kg;
  double maxTorque_Nm, torsion_Nm_per_rad, resolution_rad, gripper_N;
};
constexpr Model kModels[]{{33, 12, 5000, 30, 10e-6, 0.2, 0, 0, 0, 0},           // omega.3
                          {34, 12, 5000, 30, 10e-6, 0.2, 0, 0, 1.57e-3, 0},     // omega.6,
                          {36, 12, 5000, 30, 10e-6, 0.2, 0, 0, 1.57e-3, 0},     // for the left hand
                          {35, 12, 5000, 30, 10e-6, 0.2, 0, 0, 1.57e-3, 8},     // omega.7
                          {37, 12, 5000, 30, 10e-6, 0.2, 0, 0, 1.57e-3, 8},     //
                          {104, 12, 4000, 30, 1.5e-6, 0.3, 0.2, 1, 2.3e-4, 8},  // sigma.7
                          {105, 12, 4000, 30, 1.5e-6, 0.3, 0.2, 1, 2.3e-4, 8},  //
                          {108, 8, 8000, 0, 0, 0, 0.2, 0, 0, 0},                // lambda.7
                          {109, 8, 8000, 0, 0, 0, 0.2, 0, 0, 0},                //
                          {63, 20, 0, 0, 0, 0, 0, 0, 0, 0},                     // delta.3
                          {60, 8, 3000, 20, 60e-6, 0.25, 0, 0, 0, 0}};          // Falcon
/// Of one that stands in no list.
constexpr Model kUnknown{0, 8, 0, 0, 0, 0, 0.1, 0, 0, 0};
/// The gripper's force acts so far from its hinge, and bears so stiff a spring: both assumed.
constexpr double kGripperArm_m = 0.05, kGripperTorsion_Nm_per_rad = 1;
constexpr double kViscousFriction_Ns_per_m = 0.5,
                 kCoulombFriction_N = 0.05;  // of a grounded delta, where the mass is known

[[nodiscard]] const char* inWords(Dhd::ForceOff cause) {
  switch (cause) {
    case Dhd::ForceOff::kButton:
      return "its force button was pressed; press it again";
    case Dhd::ForceOff::kVelocity:
      return "it was moved faster than its limit of velocity";
    case Dhd::ForceOff::kWatchdog:
      return "its watchdog got no force for 25 ms";
    case Dhd::ForceOff::kSoftware:
      return "a program switched it off";
    case Dhd::ForceOff::kUsb:
      return "its USB connection was lost for a moment";
    case Dhd::ForceOff::kDeadMan:
      return "nobody holds its dead man's switch";
    case Dhd::ForceOff::kNone:
      break;
  }
  return "it does not say why";
}

/// Which device, and whether it may move by itself: "", "1", "move", "1,move".
struct Choice {
  char id = -1;
  bool mayMove = false;
};

[[nodiscard]] std::optional<Choice> choiceOf(std::string_view which) {
  Choice choice;
  if (which.ends_with("move")) {
    choice.mayMove = true;
    which.remove_suffix(4);
    if (which.ends_with(','))
      which.remove_suffix(1);
    else if (!which.empty())
      return std::nullopt;
  }
  if (which.empty()) return choice;
  int number = 0;
  const auto [end, error] = std::from_chars(which.data(), which.data() + which.size(), number);
  if (error != std::errc() || end != which.data() + which.size() || number < 0 || number > 15) return std::nullopt;
  choice.id = static_cast<char>(number);
  return choice;
}

[[nodiscard]] Vec3 fromTheirs(Vec3 v) { return {v.y, -v.x, v.z}; }
[[nodiscard]] Vec3 toTheirs(Vec3 v) { return {-v.y, v.x, v.z}; }

/// Their columns are where the handle's axes point. Not made a rotation where it is none: the server sees that.
[[nodiscard]] Quat fromTheirs(const Dhd::Frame& frame) {
  const auto column = [&](int j) { return Vec3(frame[0][j], frame[1][j], frame[2][j]); };
  // Our x is their y, our y their -x.
  return glm::quat_cast(glm::dmat3(fromTheirs(column(1)), -fromTheirs(column(0)), fromTheirs(column(2))));
}

[[nodiscard]] std::uint64_t since(std::uint64_t time_ns, std::uint64_t now_ns) {
  return now_ns - std::min(time_ns, now_ns);
}

class ForceDimension {
 public:
  ForceDimension(const Dhd& dhd, char id) : dhd_(dhd), id_(id) {}
  ~ForceDimension() {
    if (!open_) return;
    (void)set(Vec3(0), Vec3(0), 0);
    (void)dhd_.drdClose(id_);
  }
  ForceDimension(const ForceDimension&) = delete;
  ForceDimension& operator=(const ForceDimension&) = delete;

  /// Empty, or why not.
  [[nodiscard]] std::string open(bool mayMove) {
    const int opened = dhd_.drdOpenID(id_);
    if (opened < 0) return failed("cannot be opened");
    open_ = true;
    id_ = static_cast<char>(opened);
    // First of all: from here on the device is safe whatever becomes of this process.
    (void)dhd_.dhdEnableExpertMode();
    const int watched = dhd_.dhdSetWatchdog(kWatchdogPeriods, id_);
    std::string unwatched =
        watched < 0 ? failed("takes no watchdog of 25 ms, without which it would push on if the server ended") : "";
    (void)dhd_.dhdDisableExpertMode();
    if (watched < 0) return unwatched;
    if (!dhd_.drdIsInitialized(id_)) {
      if (!mayMove) {
        return name() +
               " is not initialised, for which it moves by itself: clear its way, and give the word \"move\", as in "
               "--device forcedimension:move";
      }
      if (dhd_.drdAutoInit(id_) < 0) return failed("cannot be initialised");
    }
    if (dhd_.drdStop(true, id_) < 0) return failed("is still led by its own regulation");
    turns_ = dhd_.dhdHasWrist(id_);
    hasGripper_ = dhd_.dhdHasGripper(id_);
    if (dhd_.dhdEnableForce(1, id_) < 0) return failed("does not switch its motors on");
    return {};
  }

  void describe(haptics_device_info& info) const {
    const int type = dhd_.dhdGetSystemType(id_);
    const auto* const found = std::ranges::find(kModels, type, &Model::type);
    const Model& model = found == std::ranges::end(kModels) ? kUnknown : *found;
    info = {};
    name().copy(info.name, sizeof info.name - 1);
    info.max_force_N = model.maxForce_N;
    info.max_rate_Hz = 2'000;
    info.max_stiffness_N_per_m = model.stiffness_N_per_m;
    info.max_damping_Ns_per_m = model.damping_Ns_per_m;
    info.resolution_m = model.resolution_m;
    info.delay_s = 1e-3;
    info.degrees = turns_ ? 6 : 3;
    if (model.mass_kg > 0) {
      info.mass_kg = model.mass_kg;
      info.viscous_friction_Ns_per_m = kViscousFriction_Ns_per_m;
      info.coulomb_friction_N = kCoulombFriction_N;
    }
    if (hasGripper_ && model.gripper_N > 0) {
      info.max_gripper_Nm = model.gripper_N * kGripperArm_m;
      info.max_gripper_Nm_per_rad = kGripperTorsion_Nm_per_rad;
    }
    if (!turns_) return;
    info.rotation.resolution_rad = model.resolution_rad;
    if (!dhd_.dhdHasActiveWrist(id_)) return;
    info.rotation.is_driven = 1;
    info.rotation.max_torque_Nm = model.maxTorque_Nm > 0 ? model.maxTorque_Nm : kUnknown.maxTorque_Nm;
    info.rotation.max_torsion_Nm_per_rad = model.torsion_Nm_per_rad;
  }

  [[nodiscard]] int read(std::uint64_t timeout_ns, haptics_device_state& state) {
    if (!waitForTurn(timeout_ns)) return HAPTICS_DEVICE_NOTHING;
    const std::uint64_t began_ns = monotonicNow_ns();
    Vec3 at(0);
    Dhd::Frame frame{};
    const int outcome = turns_ ? dhd_.dhdGetPositionAndOrientationFrame(&at.x, &at.y, &at.z, frame, id_)
                               : dhd_.dhdGetPosition(&at.x, &at.y, &at.z, id_);
    const std::uint64_t now_ns = monotonicNow_ns();
    if (outcome < 0) {
      const bool gone = dhd_.dhdErrorGetLast() == Dhd::kNoDeviceFound;
      const char* const words = dhd_.dhdErrorGetLastStr();
      tell(state, words != nullptr ? words : "its library names no error");
      return gone || since(well_ns_, now_ns) > kGoneAfter_ns ? HAPTICS_DEVICE_GONE : -1;
    }
    well_ns_ = now_ns;
    if (outcome == Dhd::kTimeGuard) return HAPTICS_DEVICE_NOTHING;
    if (since(status_ns_, now_ns) >= kBetweenStatus_ns) readStatus(now_ns);
    const Vec3 position = fromTheirs(at);
    const Quat rotation = turns_ ? fromTheirs(frame) : Quat(1, 0, 0, 0);
    std::copy_n(&position.x, 3, state.position_m);
    const double orientation[4]{rotation.w, rotation.x, rotation.y, rotation.z};
    std::copy_n(orientation, 4, state.orientation);
    state.age_us = static_cast<std::uint32_t>((now_ns - began_ns) / 1'000);
    readHandle(state);
    state.buttons = (dhd_.dhdGetButtonMask(id_) & (kGripperButton - 1)) | (closed_ ? kGripperButton : 0);
    state.homed = initialised_ ? 1 : 0;
    state.force_off = off_ ? 1 : 0;
    tell(state, condition(now_ns));
    return HAPTICS_DEVICE_DONE;
  }

  [[nodiscard]] int write(Vec3 force_N, Vec3 torque_Nm, double gripper_Nm) {
    const std::uint64_t now_ns = monotonicNow_ns();
    if (force_N != Vec3(0) || torque_Nm != Vec3(0) || gripper_Nm != 0) pushed_ns_ = now_ns;
    // What a person's switch took away, a person's switch brings back.
    const bool byItself = cause_ != Dhd::ForceOff::kButton && cause_ != Dhd::ForceOff::kDeadMan && !reset_;
    if (off_ && byItself && since(std::max(pushed_ns_, enabled_ns_), now_ns) > kRest_ns) {
      enabled_ns_ = now_ns;
      (void)dhd_.dhdEnableForce(1, id_);
    }
    const int outcome = set(force_N, torque_Nm, gripper_Nm);
    if (outcome == Dhd::kMotorSaturated) saturated_ns_ = now_ns;
    return outcome < 0 ? -1 : HAPTICS_DEVICE_DONE;
  }

 private:
  const Dhd& dhd_;
  char id_;
  bool open_ = false, turns_ = false, hasGripper_ = false, closed_ = false;
  bool initialised_ = true, off_ = false, reset_ = false;
  Dhd::ForceOff cause_ = Dhd::ForceOff::kNone;
  std::uint64_t next_ns_ = 0, status_ns_ = 0, well_ns_ = monotonicNow_ns();
  std::uint64_t pushed_ns_ = 0, enabled_ns_ = 0, saturated_ns_ = 0;

  [[nodiscard]] std::string name() const {
    const char* const said = open_ ? dhd_.dhdGetSystemName(id_) : nullptr;
    return said != nullptr && said[0] != 0 ? said : "Force Dimension device";
  }
  [[nodiscard]] std::string failed(const std::string& what) const {
    const char* const words = dhd_.dhdErrorGetLastStr();
    return name() + " " + what + ": " + (words != nullptr ? words : "its library names no error");
  }

  [[nodiscard]] int set(Vec3 force_N, Vec3 torque_Nm, double gripper_Nm) {
    const Vec3 f = toTheirs(force_N), t = toTheirs(torque_Nm);
    return dhd_.dhdSetForceAndTorqueAndGripperForce(f.x, f.y, f.z, t.x, t.y, t.z, gripper_Nm / kGripperArm_m, id_);
  }

  /// Until the next read is due. False: that is later than the time-out.
  [[nodiscard]] bool waitForTurn(std::uint64_t timeout_ns) {
    const std::uint64_t now_ns = monotonicNow_ns(), end_ns = now_ns + timeout_ns;
    const std::uint64_t due_ns = std::max({now_ns, next_ns_, end_ns - std::min(end_ns, kBeforeEnd_ns)});
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(due_ns, end_ns) - now_ns));
    if (due_ns > end_ns) return false;
    next_ns_ = due_ns + kBetweenReads_ns;
    return true;
  }

  void readStatus(std::uint64_t now_ns) {
    std::array<int, Dhd::kStatusCount> status{};
    if (dhd_.dhdGetStatus(status.data(), id_) < 0) return;
    status_ns_ = now_ns;
    off_ = status[Dhd::kForce] == 0;
    reset_ = status[Dhd::kReset] != 0;
    cause_ = off_ ? static_cast<Dhd::ForceOff>(status[Dhd::kForceOffCause]) : Dhd::ForceOff::kNone;
    initialised_ = dhd_.drdIsInitialized(id_) && (!turns_ || status[Dhd::kWristInitialised] != 0);
  }

  void readHandle(haptics_device_state& state) {
    state.measured = 0;
    Vec3 velocity(0);
    if (dhd_.dhdGetLinearVelocity(&velocity.x, &velocity.y, &velocity.z, id_) >= 0) {
      velocity = fromTheirs(velocity);
      std::copy_n(&velocity.x, 3, state.velocity_m_per_s);
      state.measured |= HAPTICS_DEVICE_VELOCITY;
    }
    double angle_rad = 0;
    if (!hasGripper_ || dhd_.dhdGetGripperAngleRad(&angle_rad, id_) < 0) return;
    state.gripper_rad = std::abs(angle_rad);  // of a left-handed device it is below zero
    state.measured |= HAPTICS_DEVICE_GRIPPER;
    closed_ = state.gripper_rad < (closed_ ? kOpen_rad : kClosed_rad);
  }

  [[nodiscard]] std::string condition(std::uint64_t now_ns) const {
    if (off_) return std::string("its force is off: ") + (reset_ ? "it is in reset" : inWords(cause_));
    if (!initialised_) return "it is not initialised";
    if (saturated_ns_ != 0 && since(saturated_ns_, now_ns) < kTellFor_ns)
      return "its motors are saturated: the force is less than the server's";
    return {};
  }

  static void tell(haptics_device_state& state, std::string_view words) {
    state.condition[words.copy(state.condition, sizeof state.condition - 1)] = 0;
  }
};

const char* openDevice(const char* which, void** device, haptics_device_info* info) {
  static std::string reason;
  const auto choice = choiceOf(which);
  if (!choice) return "after the colon, its number is wanted, the word \"move\", or both, as in :1,move";
  const Dhd* const dhd = Dhd::load(reason);
  if (dhd == nullptr) return reason.c_str();
  auto opened = std::make_unique<ForceDimension>(*dhd, choice->id);
  reason = opened->open(choice->mayMove);
  if (!reason.empty()) return reason.c_str();
  opened->describe(*info);
  *device = opened.release();
  return nullptr;
}

}  // namespace
}  // namespace haptics

extern "C" __attribute__((visibility("default"))) const haptics_device_functions* haptics_device_plugin() {
  using haptics::ForceDimension;
  static const haptics_device_functions functions{
      HAPTICS_DEVICE_ABI,
      haptics::openDevice,
      [](void* device, std::uint64_t timeout_ns, haptics_device_state* state) {
        return static_cast<ForceDimension*>(device)->read(timeout_ns, *state);
      },
      [](void* device, const double* f, const double* t) {
        return static_cast<ForceDimension*>(device)->write({f[0], f[1], f[2]}, {t[0], t[1], t[2]}, 0);
      },
      [](void* device) { delete static_cast<ForceDimension*>(device); },
      [](void* device, const double* f, const double* t, double gripper_Nm) {
        return static_cast<ForceDimension*>(device)->write({f[0], f[1], f[2]}, {t[0], t[1], t[2]}, gripper_Nm);
      }};
  return &functions;
}
