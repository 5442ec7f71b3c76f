#include "haptic_server/servo/settling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/maths/extent.h"
#include "common/maths/rotation.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/engine/step/tool_step.h"

namespace haptics {
namespace {

constexpr double kWindow_s = 0.3;
/// A tap bounces for seconds where little friction takes its energy: judged once it is at rest, or when it has stopped
/// getting smaller.
constexpr std::size_t kFewestWindows = 7;
constexpr std::size_t kMaxWindows = 30;
constexpr std::size_t kWindowsBack = 6;
constexpr double kShrinking = 0.97;
constexpr double kMinCycle_m = 20e-6;
constexpr double kTapHeight_m = 1e-3;
constexpr double kStrike_s = 2e-3;
/// Nobody brings a device back that was thrown so far; nothing that comes to rest gets there.
constexpr double kThrown_m = 0.05;
constexpr double kCubeSide_m = 0.1;

/// Presses along -z with a constant force, by its spring where it has one; is struck down first for a tap.
class PressingHand final : public HandIntent {
 public:
  PressingHand(const Press& press, Vec3 place)
      : start_{place, Vec3(0)}, pressing_{place, Vec3(0)}, rotation_(press.rotation) {
    start_.position.z += press.tap_m_per_s > 0 ? kTapHeight_m : press.device.resolution_m;
    if (press.hand.stiffness_N_per_m > 0) {
      pressing_.position.z -= press.force_N / press.hand.stiffness_N_per_m;
    } else {
      pressing_.push_N.z = -press.force_N;
    }
    if (press.tap_m_per_s > 0) {
      const double mass_kg = press.device.apparentMass_kg + press.hand.mass_kg;
      strike_N_.z = -(mass_kg * press.tap_m_per_s / kStrike_s + press.device.coulombFriction_N);
    }
  }
  Quat nextRotation(double /*dt_s*/) noexcept override { return rotation_; }
  HandTarget next(double dt_s, Vec3 /*felt_N*/) noexcept override {
    if (dt_s == 0) return start_;
    HandTarget now = pressing_;
    if (time_s_ < kStrike_s) now.push_N += strike_N_;
    time_s_ += dt_s;
    return now;
  }

 private:
  HandTarget start_;
  HandTarget pressing_;
  Quat rotation_;
  Vec3 strike_N_{0};
  double time_s_ = 0;
};

/// Tells a device that friction holds, under a force that does not change either: nothing will move it again, so the rest
/// of the time need not be simulated.
class StandstillDetector {
 public:
  explicit StandstillDetector(double period_s) : ticksNeeded_(static_cast<std::uint64_t>(kHeld_s / period_s)) {}

  /// @param turned_m, torque_N  On the radius of the rotation.
  void add(Vec3 place, Vec3 turned_m, Vec3 force_N, Vec3 torque_N) {
    const bool same = place == place_ && turned_m == turned_m_ && glm::distance(force_N, force_N_) <= kSameForce_N &&
                      glm::distance(torque_N, torque_N_) <= kSameForce_N;
    ticks_ = same ? ticks_ + 1 : 0;
    if (same) return;
    place_ = place;
    turned_m_ = turned_m;
    force_N_ = force_N;
    torque_N_ = torque_N;
  }
  [[nodiscard]] bool standsStill() const { return ticks_ >= ticksNeeded_; }

 private:
  /// Far longer than an observer or a filter takes to settle, 2 ms, and twice what viscous tissue takes.
  static constexpr double kHeld_s = 0.1;
  static constexpr double kSameForce_N = 1e-9;

  std::uint64_t ticksNeeded_;
  std::uint64_t ticks_ = 0;
  Vec3 place_{std::numeric_limits<double>::infinity()}, turned_m_{0};
  Vec3 force_N_{0}, torque_N_{0};
};

enum class Verdict { kNone, kRests, kMoves };

/// A trial on its way.
class RunningTrial {
 public:
  RunningTrial(const PressTrial& trial, Vec3 place)
      : press_(trial.press),
        renderer_(*trial.renderer),
        place_(place),
        hand_(press_, place),
        device_({press_.device, press_.hand, press_.period_s, press_.delay_s}, hand_),
        radius_m_(gyration_m(device_.info())),
        quantum_m_(std::max(press_.device.resolution_m, radius_m_ * press_.device.rotation.resolution_rad)),
        standstill_(press_.period_s),
        windowTicks_(static_cast<std::uint64_t>(kWindow_s / press_.period_s)) {}
  RunningTrial(const RunningTrial&) = delete;  // the device refers to the hand
  RunningTrial& operator=(const RunningTrial&) = delete;

  [[nodiscard]] SimulatedDevice& device() { return device_; }

  [[nodiscard]] Verdict tick(std::uint64_t tick) {
    const DeviceReading reading = device_.read(tick);
    renderer_.turn(reading.rotation);
    const Vec3 force_N = renderer_.tick(reading.position), torque_Nm = renderer_.torque_Nm();
    device_.writeTorque(torque_Nm);
    device_.write(force_N);
    const Vec3 position = device_.plant().position();
    const Vec3 turned_m = radius_m_ * rotationVector(device_.rotation());
    if (std::max(glm::distance(position, place_), glm::length(turned_m)) > kThrown_m) return Verdict::kMoves;
    standstill_.add(position, turned_m, force_N, torque_Nm / radius_m_);
    if (standstill_.standsStill()) return Verdict::kRests;
    extent_.add(position);
    turnedExtent_.add(turned_m);
    return (tick + 1) % windowTicks_ == 0 ? endWindow() : Verdict::kNone;
  }

 private:
  [[nodiscard]] Verdict endWindow() {
    constexpr double kRounding = 1 + 1e-6;
    const double cycle_m = std::max(extent_.longest(), turnedExtent_.longest());
    const std::size_t window = windows_++;
    cycle_m_[window] = cycle_m;
    extent_ = turnedExtent_ = {};
    if (windows_ < kFewestWindows) return Verdict::kNone;
    if (cycle_m <= kRounding * std::max(2 * quantum_m_, kMinCycle_m)) return Verdict::kRests;
    const bool shrinks = cycle_m <= kShrinking * cycle_m_[window - kWindowsBack];
    return shrinks && windows_ < kMaxWindows ? Verdict::kNone : Verdict::kMoves;
  }

  const Press& press_;
  ForceRenderer& renderer_;
  Vec3 place_;
  PressingHand hand_;
  SimulatedDevice device_;
  double radius_m_, quantum_m_;
  StandstillDetector standstill_;
  std::uint64_t windowTicks_;
  std::size_t windows_ = 0;
  Extent extent_, turnedExtent_;
  std::array<double, kMaxWindows> cycle_m_{};
};

std::shared_ptr<const CollisionMesh> makeCube() {
  constexpr float kHalf_m = static_cast<float>(kCubeSide_m / 2);
  std::array<Vec3f, 8> vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    vertices[i] = {(i & 1) != 0 ? kHalf_m : -kHalf_m, (i & 2) != 0 ? kHalf_m : -kHalf_m,
                   (i & 4) != 0 ? kHalf_m : -kHalf_m};
  }
  const std::array<std::array<std::uint32_t, 3>, 12> triangles{{{0, 2, 3},
                                                                {0, 3, 1},
                                                                {4, 5, 7},
                                                                {4, 7, 6},
                                                                {0, 1, 5},
                                                                {0, 5, 4},
                                                                {2, 6, 7},
                                                                {2, 7, 3},
                                                                {0, 4, 6},
                                                                {0, 6, 2},
                                                                {1, 3, 7},
                                                                {1, 7, 5}}};
  return buildCollisionMesh(vertices, triangles);
}

}  // namespace

ProductionStep::ProductionStep(ServoScene scene, const StepConfig& config)
    : scene_(std::move(scene)), config_(config), state_(std::make_unique<HapticState>(config)) {
  (void)adoptScene(scene_, *state_, 0);  // the first is always taken
}

Vec3 ProductionStep::tick(Vec3 measured) {
  const DeviceReading reading{measured, DeviceState::kReady, {}, rotation_};
  return hapticStep(scene_, *state_, config_, {tick_++, 0, reading}).force.written;
}

Vec3 ProductionStep::torque_Nm() const { return writtenTorque_Nm(*state_); }

bool allComeToRest(std::span<const PressTrial> trials, Vec3 place) {
  std::vector<std::unique_ptr<RunningTrial>> running;
  for (const PressTrial& trial : trials) running.push_back(std::make_unique<RunningTrial>(trial, place));
  std::vector<SimulatedDevice*> devices;
  for (std::uint64_t tick = 0; !running.empty(); ++tick) {
    devices.clear();
    for (const auto& trial : running) devices.push_back(&trial->device());
    SimulatedDevice::advanceTogether(devices, tick);
    bool anyMoves = false;
    std::erase_if(running, [&](const auto& trial) {
      const Verdict verdict = trial->tick(tick);
      anyMoves = anyMoves || verdict == Verdict::kMoves;
      return verdict != Verdict::kNone;
    });
    if (anyMoves) return false;
  }
  return true;
}

std::span<const PressKind> pressKinds() noexcept {
  static constexpr std::array<PressKind, 4> kKinds{{{0.5, 0}, {1, 0}, {0.5, 0.02}, {0.5, 0.15}}};
  return kKinds;
}

const PressedWall& pressedWall() {
  static const PressedWall wall{makeCube(), {Quat(1, 0, 0, 0), Vec3(0, 0, -kCubeSide_m / 2)}, {3e-3, 4e-3, 0}};
  return wall;
}

}  // namespace haptics
