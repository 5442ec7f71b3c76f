#include "tests/eval/teleoperation/coupled_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>

#include "haptic_server/device/plant.h"
#include "haptic_server/world/world.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/renderer.h"
#include "tests/eval/textures/closed_loop.h"

namespace haptics::eval {
namespace {

constexpr int kSubsteps = 20;
constexpr double kSubstep_s = kPeriod_s / kSubsteps;
constexpr double kEnd_s = 11.5, kFarthest_m = 0.03;

struct Stop {
  double from_s, until_s;
};
constexpr std::array kStops{Stop{1.5, 4}, Stop{5, 7.5}, Stop{9, kEnd_s}};

/// Of the least jerk.
double way(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (10 - 15 * s + 6 * s * s);
}
/// Where the hand means to be, below the surface.
double meant_m(double t) {
  constexpr double kFirst_m = 0.01, kDeeper_m = 0.005;
  return -kFarthest_m + (kFarthest_m + kFirst_m) * way(t / kStops[0].from_s) + kDeeper_m * way(t - kStops[0].until_s) -
         (kFarthest_m + kFirst_m + kDeeper_m) * way((t - kStops[1].until_s) / (kStops[2].from_s - kStops[1].until_s));
}
double meantSpeed_m_per_s(double t) {
  constexpr double kBeside_s = 1e-5;
  return (meant_m(t + kBeside_s) - meant_m(t - kBeside_s)) / (2 * kBeside_s);
}

Vec3 below(double depth_m) { return {0, 0, -depth_m}; }
double depthOf(Vec3 place_m) { return -place_m.z; }

/// A block that fills the space below z = 0, felt by the engine's step each substep: as near to a real one as its rate allows.
class Remote {
 public:
  explicit Remote(double stiffness_N_per_m)
      : world_({.rate_Hz = 1 / kSubstep_s, .maxForce_N = kMaxForce_N, .predicts = false}) {
    if (stiffness_N_per_m == 0) return;
    constexpr float s = 0.1F;
    std::vector<std::array<float, 3>> corners;
    for (int i = 0; i < 8; ++i)
      corners.push_back({(i & 1) != 0 ? s : -s, (i & 2) != 0 ? s : -s, (i & 4) != 0 ? 0 : -2 * s});
    constexpr std::array<std::array<std::uint32_t, 3>, 12> kTriangles{{{0, 2, 3},
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
    world_.add("block", {corners, kTriangles}, {.stiffness_N_per_m = stiffness_N_per_m, .damping_Ns_per_m = 0});
  }
  Vec3 force_N(Vec3 tip_m) {
    const auto& [x, y, z] = world_.step({tip_m.x, tip_m.y, tip_m.z}).force_N;
    return {x, y, z};
  }

 private:
  static constexpr double kMaxForce_N = 100;
  World world_;
};

/// A plant as its motors and encoders have it.
class Robot {
 public:
  Robot(const DevicePreset& device, const HandPreset& hand) : device_(device), plant_(device, hand) {
    plant_.place(below(-kFarthest_m));
  }
  [[nodiscard]] Vec3 measured_m() const {
    return glm::round(plant_.position() / device_.resolution_m) * device_.resolution_m;
  }
  [[nodiscard]] Vec3 limited(Vec3 force_N) const {
    const double magnitude = glm::length(force_N);
    return magnitude > device_.maxForce_N ? force_N * (device_.maxForce_N / magnitude) : force_N;
  }
  Plant& plant() { return plant_; }

 private:
  const DevicePreset& device_;
  Plant plant_;
};

/// How long after the stop a place was last farther from the last one than allowed.
double restOf(const std::vector<std::array<Vec3, 2>>& places, const Stop& stop, std::array<double, 2> allowed_m) {
  const auto at = [](double seconds) { return static_cast<std::size_t>(std::lround(seconds / kPeriod_s)); };
  const auto& last = places[at(stop.until_s) - 1];
  for (std::size_t n = at(stop.until_s); n-- > at(stop.from_s);) {
    for (std::size_t end = 0; end < 2; ++end) {
      if (glm::length(places[n][end] - last[end]) > allowed_m[end])
        return static_cast<double>(n + 1) * kPeriod_s - stop.from_s;
    }
  }
  return 0;
}

double rootMeanSquare(double sum, long count) { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0; }

/// The deadband, counted anew.
class Notice {
 public:
  void tick(Vec3 contact_N, bool sent) {
    constexpr double kShare = 0.07, kLeast_N = 0.03;
    const bool isNoticed = glm::length(contact_N - sent_N_) > std::max(kShare * glm::length(sent_N_), kLeast_N);
    if (!isNoticed) {
      ++ticks_;
      if (sent) ++sent_;
    }
    if (sent) sent_N_ = contact_N;
  }
  [[nodiscard]] double share() const { return static_cast<double>(sent_) / static_cast<double>(ticks_); }

 private:
  Vec3 sent_N_{0};
  long ticks_ = 0, sent_ = 0;
};

}  // namespace

TeleoperationRun runCell(const TeleoperationCell& cell) {
  Robot master(cell.master, cell.hand), follower(cell.follower, orThrow(findHandPreset("none")));
  Remote remote(cell.remote_N_per_m);
  const auto coupling = cell.method->make({&cell.master, &cell.follower, cell.line, cell.seed});

  TeleoperationRun run;
  std::vector<std::array<Vec3, 2>> places;
  Notice notice;
  Vec3 contact_N(0);
  double energy_J = 0, freeError = 0, freeForce = 0;
  long freeTicks = 0, back = 0;
  const auto ticks = static_cast<std::size_t>(std::lround(kEnd_s / kPeriod_s));
  const auto delayed = static_cast<std::size_t>(std::lround(cell.line.delay_s / kPeriod_s));
  for (std::size_t n = 0; n < ticks; ++n) {
    const double t = static_cast<double>(n) * kPeriod_s;
    const Vec3 masterWas = master.plant().position(), followerWas = follower.plant().position();
    places.push_back({masterWas, followerWas});
    const auto asked = coupling->tick(master.measured_m(), follower.measured_m(), contact_N);
    const Vec3 hand_N = master.limited(asked.master_N), drive_N = follower.limited(asked.follower_N);
    notice.tick(contact_N, coupling->packets().back > back);
    back = coupling->packets().back;

    constexpr std::size_t kEach = 10;
    if (n % kEach == 0)
      run.samples.push_back(
          {t, 1e3 * meant_m(t), 1e3 * depthOf(masterWas), 1e3 * depthOf(followerWas), hand_N.z, contact_N.z});
    if (t < kStops[0].from_s && depthOf(masterWas) < 0 && n >= delayed) {
      const double off_m = glm::length(followerWas - places[n - delayed][0]);
      freeError += off_m * off_m;
      freeForce += squaredLength(hand_N);
      ++freeTicks;
    }
    Vec3 contactSum(0);
    for (int i = 0; i < kSubsteps; ++i) {
      const double middle_s = t + (i + 0.5) * kSubstep_s;
      master.plant().step(kSubstep_s, hand_N, {.position = below(meant_m(middle_s))},
                          below(meantSpeed_m_per_s(middle_s)));
      const Vec3 touch_N = remote.force_N(follower.plant().position());
      contactSum += touch_N;
      follower.plant().step(kSubstep_s, drive_N + touch_N, {}, Vec3(0));
    }
    contact_N = contactSum / static_cast<double>(kSubsteps);
    energy_J -= glm::dot(hand_N, master.plant().position() - masterWas);
    energy_J -= glm::dot(drive_N, follower.plant().position() - followerWas);
    run.least_J = std::min(run.least_J, energy_J);
    if (n + 1 == static_cast<std::size_t>(std::lround(kStops[1].until_s / kPeriod_s))) {
      run.hand_N = hand_N.z;
      run.contact_N = contact_N.z;
      run.depth_mm = 1e3 * depthOf(masterWas);
      run.apart_mm = 1e3 * glm::length(masterWas - followerWas);
    }
  }
  const std::array allowed_m{1e-6 * allowedCycle_um(cell.master), 1e-6 * allowedCycle_um(cell.follower)};
  for (const Stop& stop : kStops) run.rest_s = std::max(run.rest_s, restOf(places, stop, allowed_m));
  run.freeError_mm = 1e3 * rootMeanSquare(freeError, freeTicks);
  run.freeForce_N = rootMeanSquare(freeForce, freeTicks);
  const auto [forth, all] = coupling->packets();
  run.packets = static_cast<double>(forth + all) / (2.0 * static_cast<double>(ticks));
  run.unnoticed = notice.share();
  return run;
}

}  // namespace haptics::eval
