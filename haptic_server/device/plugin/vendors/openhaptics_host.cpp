// openhaptics_host [NAME]: has OpenHaptics' library for the plug-in openhaptics.so, which starts it. A library that crashes, blocks or can
// be loaded once only does so here; and whatever becomes of the server, this process takes the force away: when none came for 20 ms,
// or the other end of the socket is closed.
//
// Frame: theirs has x to the right, y up, z to the user, in mm; ours x to the right, y away, z up, in m.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/maths/vec.h"
#include "haptic_server/device/plugin/vendors/hd.h"
#include "haptic_server/device/plugin/vendors/openhaptics_link.h"

namespace haptics {
namespace {

constexpr std::uint64_t kSilence_ns = 20'000'000;
/// After a tick that came so late the last force has acted for too long already.
constexpr std::uint64_t kLate_ns = 5'000'000;
/// After its library said that a limit was exceeded, the motors are off for a moment and come back by a ramp.
constexpr std::uint64_t kRamp_ns = 100'000'000;
constexpr int kTicksBetweenCalibrations = 10;
constexpr double kMillimetre = 1e-3;

[[nodiscard]] Vec3 fromTheirs(const double* v) { return {v[0], -v[2], v[1]}; }

/// Of a transform in columns. Where it is a rotation but for rounding, it is made one; else the server sees that it is none.
[[nodiscard]] Quat rotationOf(const double* transform) {
  const Quat q =
      glm::quat_cast(glm::dmat3(fromTheirs(transform), -fromTheirs(transform + 8), fromTheirs(transform + 4)));
  return std::abs(glm::dot(q, q) - 1) < 0.05 ? glm::normalize(q) : q;
}

void copyWords(std::string_view words, char* text, std::size_t size) { text[words.copy(text, size - 1)] = 0; }

class Host {
 public:
  explicit Host(const Hd& hd) : hd_(hd) {}

  /// Empty, or why not.
  [[nodiscard]] std::string open(const char* name, haptics_device_info& info) {
    device_ = hd_.hdInitDevice(name != nullptr ? name : "Default PHANToM");
    // Drivers of 2022 know none by its name; older ones crash on this.
    if (device_ == Hd::kInvalidHandle && name == nullptr) {
      (void)hd_.hdGetError();
      device_ = hd_.hdInitDevice(nullptr);
    }
    const unsigned error = hd_.hdGetError().errorCode;
    if (device_ == Hd::kInvalidHandle) return "OpenHaptics cannot open the device: " + Hd::inWords(error);
    hd_.hdMakeCurrentDevice(device_);
    describe(info);
    int styles = 0;
    hd_.hdGetIntegerv(Hd::kCalibrationStyles, &styles);
    for (const int style : {1, 2, 4}) {  // encoder reset, by itself, inkwell: the last one that it has
      if ((styles & style) != 0) style_ = static_cast<unsigned>(style);
    }
    hd_.hdEnable(Hd::kForceOutput);
    scheduled_ = hd_.hdScheduleAsynchronous([](void* host) { return static_cast<Host*>(host)->tick(); }, this,
                                            Hd::kDefaultPriority);
    hd_.hdSetSchedulerRate(1000);
    hd_.hdStartScheduler();
    if (const unsigned failed = hd_.hdGetError().errorCode; failed != 0 && failed != Hd::kWarmMotors)
      return "OpenHaptics does not start: " + Hd::inWords(failed);
    return {};
  }
  void start() { told_ = true; }

  void close() {
    ended_ = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // some ticks without force
    hd_.hdStopScheduler();
    hd_.hdUnschedule(scheduled_);
    hd_.hdDisableDevice(device_);
  }

 private:
  const Hd& hd_;
  unsigned device_ = Hd::kInvalidHandle, style_ = 0, calibration_ = Hd::kCalibrated;
  unsigned long scheduled_ = 0;
  std::atomic<bool> ended_{false}, told_{false};
  // The scheduler's.
  HostForce force_{};
  std::uint64_t ticked_ns_ = 0, forced_ns_ = 0, exceeded_ns_ = 0;
  unsigned exceeded_ = 0;
  int ticks_ = 0;

  void describe(haptics_device_info& info) const {
    const char* const model = hd_.hdGetString(Hd::kModel);
    copyWords(model != nullptr && model[0] != 0 ? model : "OpenHaptics device", info.name, sizeof info.name);
    double maxForce_N = 0;
    hd_.hdGetDoublev(Hd::kMaxForce, &maxForce_N);
    info.max_force_N = maxForce_N > 0 && maxForce_N < 50 ? maxForce_N : 3.3;
    info.max_rate_Hz = 1'000;
    info.delay_s = 1e-3;
    info.degrees = 6;
    // As haptic_server/device/presets.cpp has the Touch, which says what of it is assumed. Of others neither is known here.
    if (std::string_view(info.name).find("Touch X") == std::string_view::npos &&
        (std::string_view(info.name).find("Touch") != std::string_view::npos ||
         std::string_view(info.name).find("Omni") != std::string_view::npos)) {
      info.max_stiffness_N_per_m = 400;
      info.max_damping_Ns_per_m = 4;
      info.resolution_m = 55e-6;
      info.mass_kg = 0.045;
      info.viscous_friction_Ns_per_m = 0.05;
      info.coulomb_friction_N = 0.26;
    }
  }

  void takeForce(std::uint64_t now_ns) {
    HostForce force;
    while (::recv(kHostSocket, &force, sizeof force, MSG_DONTWAIT) == sizeof force) {
      force_ = force;
      forced_ns_ = now_ns;
    }
    const bool isLate = now_ns - std::min(now_ns, std::exchange(ticked_ns_, now_ns)) > kLate_ns;
    if (ended_ || isLate || now_ns - std::min(now_ns, forced_ns_) > kSilence_ns) force_ = {};
  }

  void calibrate() {
    if (ticks_++ % kTicksBetweenCalibrations != 0) return;
    calibration_ = hd_.hdCheckCalibration();
    if (calibration_ == Hd::kNeedsUpdate && style_ != 0) hd_.hdUpdateCalibration(style_);
  }

  [[nodiscard]] unsigned tick() {
    const std::uint64_t now_ns = monotonicNow_ns();
    takeForce(now_ns);
    double position[3]{}, velocity[3]{}, transform[16]{};
    int buttons = 0;
    const double* const f = force_.force_N;
    const double theirs[3]{f[0], f[2], -f[1]};
    hd_.hdBeginFrame(device_);
    hd_.hdGetDoublev(Hd::kPosition, position);
    hd_.hdGetDoublev(Hd::kVelocity, velocity);
    hd_.hdGetDoublev(Hd::kTransform, transform);
    hd_.hdGetIntegerv(Hd::kButtons, &buttons);
    hd_.hdSetDoublev(Hd::kForce, theirs);
    hd_.hdEndFrame(device_);
    HostState said{.state = {}, .measured_ns = now_ns, .isBroken = 0, .reserved = 0};
    const unsigned error = hd_.hdGetError().errorCode;
    calibrate();
    const Vec3 at = kMillimetre * fromTheirs(position);
    const Quat q = rotationOf(transform);
    std::copy_n(&at.x, 3, said.state.position_m);
    const Vec3 moving = kMillimetre * fromTheirs(velocity);
    std::copy_n(&moving.x, 3, said.state.velocity_m_per_s);
    said.state.measured = HAPTICS_DEVICE_VELOCITY;
    const double orientation[4]{q.w, q.x, q.y, q.z};
    std::copy_n(orientation, 4, said.state.orientation);
    said.state.buttons = static_cast<std::uint32_t>(buttons);
    said.state.homed = calibration_ == Hd::kCalibrated ? 1 : 0;
    judge(error, now_ns, said);
    if (told_) (void)::send(kHostSocket, &said, sizeof said, MSG_DONTWAIT | MSG_NOSIGNAL);
    return Hd::kContinue;
  }

  void judge(unsigned error, std::uint64_t now_ns, HostState& said) {
    std::string words;
    if (error >= Hd::kExceededForce && error <= Hd::kForceError) {
      exceeded_ = error;
      exceeded_ns_ = now_ns;
    } else if (error != 0) {
      words = Hd::inWords(error);
      said.isBroken = error == Hd::kWarmMotors ? 0 : 1;
    }
    if (exceeded_ != 0 && now_ns - exceeded_ns_ < kRamp_ns) {
      said.state.force_off = 1;
      words = "its force is off: " + Hd::inWords(exceeded_);
    }
    if (said.state.homed == 0 && words.empty()) words = "it is not calibrated: put the stylus into its inkwell";
    copyWords(words, said.state.condition, sizeof said.state.condition);
  }
};

int run(const char* name) {
  HostHello hello{};
  std::string reason;
  const auto say = [&] {
    copyWords(reason, hello.refusal, sizeof hello.refusal);
    (void)::send(kHostSocket, &hello, sizeof hello, MSG_NOSIGNAL);
    return 1;
  };
  const Hd* const hd = Hd::load(reason);
  if (hd == nullptr) return say();
  Host host(*hd);
  reason = host.open(name, hello.info);
  if (!reason.empty()) return say();
  (void)say();
  host.start();
  pollfd end{kHostSocket, POLLRDHUP, 0};
  while (::poll(&end, 1, -1) < 0 || (end.revents & (POLLRDHUP | POLLHUP)) == 0) {
  }
  ::alarm(2);  // should the library not let go
  host.close();
  return 0;
}

}  // namespace
}  // namespace haptics

int main(int argc, char** argv) { return haptics::run(argc > 1 ? argv[1] : nullptr); }
