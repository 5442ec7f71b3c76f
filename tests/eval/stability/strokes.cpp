#include "tests/eval/stability/strokes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_server/device/exploring_hand.h"
#include "haptic_server/device/simulated_device.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/renderer.h"
#include "tests/eval/step_config.h"

namespace haptics::eval {
namespace {

constexpr double kAbove_m = 2e-3;
constexpr double kStroke_m = 0.02;
constexpr double kPress_N = 1;

/// Down until the spring would press 1 N on the surface, along it and back, up again: reaches of least jerk.
class StrokingHand final : public HandIntent {
 public:
  StrokingHand(const TestSurface& ground, const HandPreset& hand) {
    const Vec3 above = ground.place + Vec3(0, 0, kAbove_m);
    const Vec3 down = ground.place - Vec3(0, 0, kPress_N / hand.stiffness_N_per_m);
    const Vec3 along(ground.name == "sphere" ? kStroke_m / 4 : kStroke_m, 0, 0);
    way_ = {{above, down, 0.3}, {down, down, 0.2},  {down, down + along, 0.4}, {down + along, down, 0.4},
            {down, down, 0.2},  {down, above, 0.3}, {above, above, 0.2}};
  }
  HandTarget next(double dt_s, Vec3 /*felt_N*/) noexcept override {
    way_[now_].elapsed_s += dt_s;
    if (way_[now_].done() && now_ + 1 < way_.size()) ++now_;
    return {way_[now_].position(), Vec3(0)};
  }
  [[nodiscard]] bool lifting() const { return now_ + 2 >= way_.size(); }
  [[nodiscard]] double duration_s() const {
    double sum = 0;
    for (const Reach& reach : way_) sum += reach.duration_s;
    return sum;
  }

 private:
  std::vector<Reach> way_;
  std::size_t now_ = 0;
};

class PushingHand final : public HandIntent {
 public:
  explicit PushingHand(Vec3 from) : from_(from) {}
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {from_, {0, 0, -kPress_N}}; }

 private:
  Vec3 from_;
};

struct Fidelity {
  double error_ratio = 0;  ///< RMS of what the force is off, over the RMS of what it should be.
  double pull_N = 0;       ///< Largest towards the surface while the hand leaves.
};

Fidelity stroke(const Loop& loop) {
  StrokingHand hand(*loop.ground, loop.hand);
  SimulatedDevice device({withoutRotation(loop.device), loop.hand, kPeriod_s, loop.delay_s}, hand);
  const double stiffness = loop.device.maxStiffness_N_per_m;
  const auto method =
      loop.method->make({loop.ground, loop.device, kPeriod_s, loop.delay_s, stiffness, loop.damping_Ns_per_m});
  double off = 0, all = 0;
  Fidelity result;
  const auto ticks = static_cast<std::uint64_t>(hand.duration_s() / kPeriod_s);
  Vec3 force(0);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const Vec3 measured = device.read(tick).position;
    // What acted until now, against the spring at the place where it acted.
    const double right_N = std::max(0.0, -stiffness * device.plant().position().z);
    off += (force.z - right_N) * (force.z - right_N);
    all += right_N * right_N;
    force = method->tick(measured);
    device.write(force);
    if (hand.lifting()) result.pull_N = std::max(result.pull_N, -force.z);
  }
  result.error_ratio = std::sqrt(off / all);
  return result;
}

struct Balance {
  double least_J = std::numeric_limits<double>::infinity();
};

/// Of any rate of steps, by what the motors really do on the device's true way.
Balance balanceOf(StabilityMethod& method, SimulatedDevice& device, double friction_Ns_per_m, std::uint64_t ticks) {
  double taken_J = 0;
  Balance balance;
  Vec3 force(0);
  Vec3 before = device.plant().position();
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const Vec3 measured = device.read(tick).position;
    const Vec3 now = device.plant().position();
    if (tick > 0) {
      taken_J -= glm::dot(force, now - before);
      taken_J += friction_Ns_per_m * squaredLength(now - before) / kPeriod_s;
      balance.least_J = std::min(balance.least_J, taken_J);
    }
    before = now;
    force = method.tick(measured);
    device.write(force);
  }
  return balance;
}

Record energyRecord(const Loop& loop, double least_J) {
  const double step_m = loop.device.resolution_m;
  constexpr double kSlack_J = 10e-6;
  const double allowed_J = loop.device.maxStiffness_N_per_m * step_m * step_m / 2 + kSlack_J;
  const bool ours = loop.method->name == kOursMethod;
  return {{"method", loop.method->name},
          {"scene", "energy_" + loop.ground->name},
          {"device", loop.device.name},
          {"hand", loop.hand.name},
          {"least_energy_taken_uJ", least_J * 1e6},
          {"allowed_uJ", -allowed_J * 1e6},
          {"pass", !ours || least_J >= -allowed_J}};
}

}  // namespace

std::vector<Record> measureFidelity(Scope scope, const CaseChoice& isChosen) {
  const TestSurface wall = makeWall();
  std::vector<Record> records;
  const auto devices = scope == Scope::kShort ? devicePresets().first(1) : devicePresets();
  std::size_t at = 0;
  for (const DevicePreset& device : devices) {
    if (!isChosen(at++, devices.size())) continue;
    double bare = 0;
    for (const MethodEntry& method : stabilityMethods()) {
      const Loop loop{&method, &wall, device, orThrow(findHandPreset("nominal"))};
      const Fidelity fidelity = stroke(loop);
      if (method.name == "nothing") bare = fidelity.error_ratio;
      constexpr double kMaxError = 1.5, kMaxPull_N = 1e-9;
      const bool good = fidelity.error_ratio <= kMaxError * bare && fidelity.pull_N <= kMaxPull_N;
      records.push_back({{"method", method.name},
                         {"scene", "press_stroke_lift"},
                         {"device", device.name},
                         {"hand", loop.hand.name},
                         {"K_N_per_m", device.maxStiffness_N_per_m},
                         {"force_error_rms_ratio", fidelity.error_ratio},
                         {"over_that_of_nothing", fidelity.error_ratio / bare},
                         {"pull_on_release_N", fidelity.pull_N},
                         {"pass", method.name != kOursMethod || good}});
    }
  }
  return records;
}

std::vector<Record> measureEnergy(Scope scope, const CaseChoice& isChosen) {
  const std::vector<TestSurface> grounds{makeWall(), makeOuterEdge(), makeBall(), makeRoughWall()};
  std::vector<Record> records;
  const auto devices = scope == Scope::kShort ? devicePresets().first(1) : devicePresets();
  std::size_t at = 0;
  for (const TestSurface& ground : grounds) {
    for (const DevicePreset& device : devices) {
      for (const MethodEntry& method : stabilityMethods()) {
        if (!isChosen(at++, grounds.size() * devices.size() * stabilityMethods().size())) continue;
        const bool ours = method.name == kOursMethod;
        if (ground.friction && !ours) continue;
        for (const HandPreset& hand : handPresets().first(2)) {
          const Loop loop{&method, &ground, device, hand};
          const auto renders = method.make({&ground, device, kPeriod_s, 0, device.maxStiffness_N_per_m, 0});
          double least_J = 0;
          if (hand.stiffness_N_per_m > 0) {
            StrokingHand strokes(ground, hand);
            SimulatedDevice simulated({withoutRotation(device), hand, kPeriod_s, 0}, strokes);
            const auto ticks = static_cast<std::uint64_t>(strokes.duration_s() / kPeriod_s);
            least_J = balanceOf(*renders, simulated, device.viscousFriction_Ns_per_m, ticks).least_J;
          } else {
            if (ground.name == "sphere") continue;  // slides off
            constexpr std::uint64_t kTicks = 2000;
            PushingHand pushes(ground.place + Vec3(0, 0, device.resolution_m));
            SimulatedDevice simulated({withoutRotation(device), hand, kPeriod_s, 0}, pushes);
            least_J = balanceOf(*renders, simulated, device.viscousFriction_Ns_per_m, kTicks).least_J;
          }
          records.push_back(energyRecord(loop, least_J));
        }
      }
    }
  }
  return records;
}

}  // namespace haptics::eval
