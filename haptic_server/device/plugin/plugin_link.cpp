#include "haptic_server/device/plugin/plugin_link.h"

#include <dlfcn.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <locale>
#include <optional>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/maths/rotation.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

constexpr const char* kSymbol = "haptics_device_plugin";
/// What came since stands at the end of its structures.
constexpr std::uint32_t kOldestAbi = 2;
static_assert(offsetof(haptics_device_info, max_gripper_Nm) == 200 && offsetof(haptics_device_state, force_off) == 72);
constexpr double kMaxForce_N = 100;
/// No arm reaches farther from the middle of its workspace.
constexpr double kFarthest_m = 10;
constexpr double kMaxTorque_Nm = 20, kMaxGripper_Nm = 5;
/// Between looks at a plug-in that does not wait by itself.
constexpr std::uint64_t kLookAgain_ns = 100'000;
/// A call that took so much longer than it was allowed to has kept the force from being written.
constexpr std::uint64_t kTooLong_ns = 4'000'000;
constexpr std::uint64_t kWarnAgain_ns = 1'000'000'000;

[[nodiscard]] tl::unexpected<Error> outOfRange(const char* field, double value, double most) {
  return refused(field,
                 "is " + std::to_string(value) + "; the plug-in is to say a number from 0 to " + std::to_string(most));
}

[[nodiscard]] Result<void> check(const haptics_device_info& info, bool writesGripper) {
  if (std::memchr(info.name, 0, sizeof info.name) == nullptr || info.name[0] == 0)
    return refused("name", "is empty, or does not end");
  const std::tuple<const char*, double, double> numbers[] = {
      {"max_force_N", info.max_force_N, kMaxForce_N},
      {"max_rate_Hz", info.max_rate_Hz, 2e4},
      {"max_stiffness_N_per_m", info.max_stiffness_N_per_m, 1e6},
      {"max_damping_Ns_per_m", info.max_damping_Ns_per_m, 1e4},
      {"resolution_m", info.resolution_m, 0.1},
      {"mass_kg", info.mass_kg, 100},
      {"viscous_friction_Ns_per_m", info.viscous_friction_Ns_per_m, 1e3},
      {"coulomb_friction_N", info.coulomb_friction_N, 1e3},
      {"delay_s", info.delay_s, 0.1},
      {"rotation.max_torque_Nm", info.rotation.max_torque_Nm, kMaxTorque_Nm},
      {"rotation.max_torsion_Nm_per_rad", info.rotation.max_torsion_Nm_per_rad, 1e3},
      {"rotation.resolution_rad", info.rotation.resolution_rad, 1},
      {"rotation.inertia_kgm2", info.rotation.inertia_kgm2, 10},
      {"rotation.viscous_friction_Nms_per_rad", info.rotation.viscous_friction_Nms_per_rad, 100},
      {"rotation.coulomb_friction_Nm", info.rotation.coulomb_friction_Nm, 100},
      {"max_gripper_Nm", info.max_gripper_Nm, kMaxGripper_Nm},
      {"max_gripper_Nm_per_rad", info.max_gripper_Nm_per_rad, 100}};
  for (const auto& [field, value, most] : numbers) {
    if (!(value >= 0 && value <= most)) return outOfRange(field, value, most);
  }
  if (info.max_force_N == 0) return refused("max_force_N", "is 0; give what the device can do");
  if (info.max_rate_Hz < 100) return refused("max_rate_Hz", "is below 100; no surface is felt so");
  if (info.degrees != 3 && info.degrees != 6)
    return refused("degrees", "is " + std::to_string(info.degrees) + "; 3 or 6 will do");
  if (info.rotation.is_driven > 1)
    return refused("rotation.is_driven", "is " + std::to_string(info.rotation.is_driven) + "; 0 or 1 will do");
  if (info.rotation.is_driven == 1 && info.degrees != 6)
    return refused("rotation.is_driven",
                   "is 1 of a device that does not sense how it is turned; its degrees should be 6");
  if (info.rotation.is_driven == 1 && info.rotation.max_torque_Nm == 0)
    return refused("rotation.max_torque_Nm", "is 0; a device that gives torque has a limit: give what it can do");
  if (info.max_gripper_Nm > 0 && info.max_gripper_Nm_per_rad == 0)
    return refused("max_gripper_Nm_per_rad", "is 0; give how stiff a spring the gripper bears");
  if (info.max_gripper_Nm > 0 && !writesGripper)
    return refused("max_gripper_Nm", "is above 0, and the plug-in has no write_gripper()");
  return {};
}

/// Numbers in replies, logs and files have points, whatever locale a vendor's library gives the process, its streams or the thread.
class KeptLocale {
 public:
  KeptLocale() = default;
  ~KeptLocale() {
    if (::uselocale(nullptr) != LC_GLOBAL_LOCALE) ::uselocale(LC_GLOBAL_LOCALE);
    if (std::locale() != std::locale::classic()) std::locale::global(std::locale::classic());
    if (std::strcmp(::setlocale(LC_NUMERIC, nullptr), "C") != 0) ::setlocale(LC_NUMERIC, "C");
  }
  KeptLocale(const KeptLocale&) = delete;
  KeptLocale& operator=(const KeptLocale&) = delete;
};

/// What a plug-in in C++ throws ends here.
template <class Call, class Outcome>
[[nodiscard]] Outcome caught(Call call, Outcome thrown) noexcept {
  const KeptLocale locale;
  try {
    return call();
  } catch (...) {
    return thrown;
  }
}

/// Null, or why not.
[[nodiscard]] const char* openDevice(const haptics_device_functions& functions, const std::string& which, void*& device,
                                     haptics_device_info& info) noexcept {
  return caught([&] { return functions.open(which.c_str(), &device, &info); }, "its open() throws an exception");
}

void closeDevice(const haptics_device_functions& functions, void* device) noexcept {
  (void)caught([&] { return functions.close(device), true; }, false);
}

class PluginPort final : public UsbPort {
 public:
  PluginPort(const haptics_device_functions& functions, void* device, const haptics_device_info& info,
             const std::function<void(const std::string&)>& warning)
      : functions_(functions),
        device_(device),
        name_(info.name),
        hasGripper_(info.max_gripper_Nm > 0 && functions.write_gripper != nullptr),
        warning_(warning) {}
  ~PluginPort() override { closeDevice(functions_, device_); }
  PluginPort(const PluginPort&) = delete;
  PluginPort& operator=(const PluginPort&) = delete;

  [[nodiscard]] UsbOutcome control(const UsbRequest& /*request*/) override { return UsbOutcome::kDone; }
  [[nodiscard]] UsbOutcome clearStall() override { return UsbOutcome::kDone; }

  [[nodiscard]] UsbOutcome send(std::span<const std::uint8_t> bytes) override {
    std::array<double, 7> output;
    std::memcpy(output.data(), bytes.data(), sizeof output);
    const double *const force_N = output.data(), *const torque_Nm = force_N + 3;
    const int outcome = call(hasGripper_ ? "write_gripper" : "write", monotonicNow_ns(), [&] {
      return hasGripper_ ? functions_.write_gripper(device_, force_N, torque_Nm, output[6])
                         : functions_.write(device_, force_N, torque_Nm);
    });
    if (outcome == HAPTICS_DEVICE_DONE) return UsbOutcome::kDone;
    return outcome == HAPTICS_DEVICE_GONE ? UsbOutcome::kGone : UsbOutcome::kFailed;
  }

  [[nodiscard]] UsbArrival next(std::uint64_t deadline_ns) override {
    for (;;) {
      const std::uint64_t now_ns = monotonicNow_ns();
      // One that always has something new would be read without end; one that is late is still read once.
      if (now_ns >= deadline_ns && std::exchange(read_, false)) return {UsbArrival::Kind::kDeadline, {}};
      read_ = true;
      const std::uint64_t timeout_ns = deadline_ns - std::min(deadline_ns, now_ns);
      const int outcome =
          call("read", now_ns + timeout_ns, [&] { return functions_.read(device_, timeout_ns, &state_); });
      noteCondition();
      if (outcome == HAPTICS_DEVICE_DONE) {
        return {UsbArrival::Kind::kBytes, {reinterpret_cast<const std::uint8_t*>(&state_), sizeof state_}};
      }
      if (outcome == HAPTICS_DEVICE_GONE) return {UsbArrival::Kind::kGone, {}};
      const std::uint64_t later_ns = monotonicNow_ns();
      if (outcome != HAPTICS_DEVICE_NOTHING) return {UsbArrival::Kind::kFailed, {}};
      if (later_ns >= deadline_ns) continue;
      std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(kLookAgain_ns, deadline_ns - later_ns)));
    }
  }

 private:
  const haptics_device_functions& functions_;
  void* device_;
  std::string name_;
  bool hasGripper_;  // that gives a moment
  const std::function<void(const std::string&)>& warning_;
  haptics_device_state state_{};
  std::string condition_;
  std::uint64_t warned_ns_ = 0;
  bool read_ = false;  // since the last deadline

  /// The function's outcome; one that throws says that the device is gone.
  template <class Call>
  [[nodiscard]] int call(const char* function, std::uint64_t until_ns, Call call) {
    const std::optional<int> outcome = caught([&] { return std::optional(call()); }, std::optional<int>());
    noteTime(function, until_ns);
    if (!outcome) warning_(name_ + ": its plug-in's " + function + "() throws an exception");
    return outcome.value_or(HAPTICS_DEVICE_GONE);
  }

  void noteCondition() {
    state_.condition[sizeof state_.condition - 1] = 0;
    if (condition_ == state_.condition) return;
    condition_ = state_.condition;
    if (!condition_.empty()) warning_(name_ + ": " + printable(condition_));
  }

  void noteTime(const char* function, std::uint64_t until_ns) {
    const std::uint64_t now_ns = monotonicNow_ns();
    if (now_ns < until_ns + kTooLong_ns || (warned_ns_ != 0 && now_ns - warned_ns_ < kWarnAgain_ns)) return;
    warned_ns_ = now_ns;
    warning_(name_ + ": its plug-in's " + function + "() took " + std::to_string((now_ns - until_ns) / 1'000'000) +
             " ms longer than it may");
  }
};

[[nodiscard]] DeviceRotation rotationOf(const haptics_device_info& said) {
  if (said.degrees != 6) return {};
  const haptics_device_rotation& rotation = said.rotation;
  return {.isSensed = true,
          .maxTorque_Nm = rotation.is_driven == 1 ? rotation.max_torque_Nm : 0,
          .maxTorsion_Nm_per_rad = rotation.max_torsion_Nm_per_rad,
          .resolution_rad = rotation.resolution_rad,
          .inertia_kgm2 = rotation.inertia_kgm2,
          .viscousFriction_Nms_per_rad = rotation.viscous_friction_Nms_per_rad,
          .coulombFriction_Nm = rotation.coulomb_friction_Nm};
}

/// Without what is not finite.
[[nodiscard]] HandleReading handleOf(const haptics_device_state& said, Vec3 sense) {
  HandleReading handle;
  const auto vectorOf = [&](const double* v) { return sense * Vec3(v[0], v[1], v[2]); };
  if ((said.measured & HAPTICS_DEVICE_VELOCITY) != 0 && isFinite(vectorOf(said.velocity_m_per_s))) {
    handle.velocity = vectorOf(said.velocity_m_per_s);
    handle.measured |= HandleReading::kVelocity;
  }
  if ((said.measured & HAPTICS_DEVICE_APPLIED_FORCE) != 0 && isFinite(vectorOf(said.applied_force_N))) {
    handle.appliedForce_N = vectorOf(said.applied_force_N);
    handle.measured |= HandleReading::kAppliedForce;
  }
  if ((said.measured & HAPTICS_DEVICE_GRIPPER) != 0 && std::isfinite(said.gripper_rad)) {
    handle.gripper_rad = said.gripper_rad;
    handle.measured |= HandleReading::kGripper;
  }
  return handle;
}

/// Shortened to the limit, zero where it is not finite.
[[nodiscard]] Vec3 bounded(Vec3 output, double limit) noexcept {
  const double length = glm::length(output);
  if (!std::isfinite(length)) return Vec3(0);
  return length > limit ? limit / length * output : output;
}

[[nodiscard]] DeviceInfo infoOf(const haptics_device_info& said, const DeviceCalibration& calibration, double scale) {
  return {.name = asUtf8(said.name),
          .maxForce_N = std::min(said.max_force_N, calibration.maxForce_N.value_or(said.max_force_N)),
          .maxStiffness_N_per_m = said.max_stiffness_N_per_m / scale,
          .maxDamping_Ns_per_m = said.max_damping_Ns_per_m / scale,
          .resolution_m = said.resolution_m * scale,
          .apparentMass_kg = said.mass_kg / scale,
          .viscousFriction_Ns_per_m = said.viscous_friction_Ns_per_m / scale,
          .coulombFriction_N = said.coulomb_friction_N,
          .delay_s = said.delay_s,
          .rotation = rotationOf(said),
          .gripper = {.maxMoment_Nm = said.max_gripper_Nm, .maxStiffness_Nm_per_rad = said.max_gripper_Nm_per_rad}};
}

}  // namespace

Result<PluginLibrary> PluginLibrary::load(const std::string& file) {
  // What it forks dies with the thread that called it.
  static const int once = ::pthread_atfork(nullptr, nullptr, [] { ::prctl(PR_SET_PDEATHSIG, SIGKILL); });
  static_cast<void>(once);
  // With a slash in it dlopen() looks nowhere else.
  const std::string path = file.find('/') == std::string::npos ? "./" + file : file;
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
    return refused(file, "is not a regular file");
  void* const library =
      caught([&] { return dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL); }, static_cast<void*>(nullptr));
  if (library == nullptr) {
    const char* const why = dlerror();
    return refused(file,
                   std::string("cannot be loaded: ") + (why != nullptr ? why : "it throws an exception as it is"));
  }
  using Entry = const haptics_device_functions* (*)();
  const auto entry = reinterpret_cast<Entry>(dlsym(library, kSymbol));
  if (entry == nullptr)
    return refused(file, std::string("has no function ") + kSymbol + "(); see haptics/device_plugin.h");
  const auto* const functions = caught(entry, static_cast<const haptics_device_functions*>(nullptr));
  if (functions == nullptr) return refused(file, std::string(kSymbol) + "() returns nothing");
  if (functions->abi < kOldestAbi || functions->abi > HAPTICS_DEVICE_ABI) {
    return refused(file, "is a plug-in of version " + std::to_string(functions->abi) + "; this server has versions " +
                             std::to_string(kOldestAbi) + " to " + std::to_string(HAPTICS_DEVICE_ABI) +
                             ": build it with this server's device_plugin.h");
  }
  if (!functions->open || !functions->read || !functions->write || !functions->close)
    return refused(file, "lacks one of open, read, write and close");
  haptics_device_functions known{};  // an older plug-in's end earlier
  std::memcpy(&known, functions, functions->abi < 4 ? offsetof(haptics_device_functions, write_gripper) : sizeof known);
  return PluginLibrary(file, known);
}

Result<haptics_device_info> PluginLibrary::describe(const std::string& which) const {
  void* device = nullptr;
  haptics_device_info info{};
  if (const char* reason = openDevice(functions_, which, device, info)) return refused(file_, reason);
  closeDevice(functions_, device);
  if (auto checked = check(info, functions_.write_gripper != nullptr); !checked)
    return tl::unexpected(std::move(checked.error()).within(file_ + ": "));
  return info;
}

std::uint64_t PluginBus::clock_ns() noexcept { return monotonicNow_ns(); }

void PluginBus::sleepUntil(std::uint64_t time_ns) {
  if (const std::uint64_t now_ns = monotonicNow_ns(); now_ns < time_ns) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(time_ns - now_ns));
  }
}

std::vector<UsbPlace> PluginBus::list(const UsbModel& /*model*/) { return {{.path = library_.file(), .serial = {}}}; }

tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> PluginBus::open(const UsbModel& /*model*/,
                                                                   const UsbPlace& /*place*/) {
  void* device = nullptr;
  haptics_device_info info{};
  if (const char* reason = openDevice(library_.functions(), which_, device, info)) {
    return tl::unexpected(UsbRefusal{DeviceFault::kNotAnswering, {library_.file(), reason}});
  }
  return std::make_unique<PluginPort>(library_.functions(), device, info, warning_);
}

PluginProtocol::PluginProtocol(const haptics_device_info& description, const DeviceCalibration& calibration)
    : placement_(calibration, Quat(1, 0, 0, 0), Vec3(0)),
      sense_(calibration.sense()),
      handedness_(sense_.x * sense_.y * sense_.z),
      forceScale_(calibration.forceScale.value_or(1)),
      info_(infoOf(description, calibration, placement_.scale())) {}

bool PluginProtocol::take(std::span<const std::uint8_t> bytes, const std::function<void(const DeviceReply&)>& found) {
  haptics_device_state state;
  if (bytes.size() != sizeof state) return true;
  std::memcpy(&state, bytes.data(), sizeof state);
  position_ = sense_ * Vec3(state.position_m[0], state.position_m[1], state.position_m[2]);
  const double* q = state.orientation;
  if (info_.rotation.isSensed) rotation_ = Quat(q[0], handedness_ * sense_ * Vec3(q[1], q[2], q[3]));
  handle_ = handleOf(state, sense_);
  DeviceReply reply;
  reply.buttons = state.buttons;
  reply.homedAxes = state.homed != 0 ? kAllAxes : 0;
  reply.age_us = state.age_us;
  reply.forceOff = state.force_off != 0;
  found(reply);
  return false;
}

std::optional<Vec3> PluginProtocol::locate(const DeviceReply& /*reply*/) {
  if (!(glm::length(position_) <= kFarthest_m) || !isRotation(rotation_)) return std::nullopt;  // also of NaN
  rotation_ = glm::normalize(rotation_);
  return position_;
}

void PluginProtocol::setTorque(Vec3 torque_Nm, double grip_Nm) noexcept {
  const Vec3 scaled = forceScale_ * handedness_ * sense_ * bounded(torque_Nm, info_.rotation.maxTorque_Nm);
  std::copy_n(&scaled.x, 3, output_.begin() + 3);
  output_[6] = forceScale_ * bounded({grip_Nm, 0, 0}, info_.gripper.maxMoment_Nm).x;
}

std::span<const std::uint8_t> PluginProtocol::command(Vec3 force_N, DeviceLight /*light*/) {
  const Vec3 scaled = forceScale_ * sense_ * bounded(force_N, info_.maxForce_N);
  std::copy_n(&scaled.x, 3, output_.begin());
  return {reinterpret_cast<const std::uint8_t*>(output_.data()), sizeof output_};
}

}  // namespace haptics
