// The scene is edited under the hand: S17.

#include <algorithm>
#include <cmath>

#include "tests/eval/scenes/edits_at_rest.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kBallRadius = 0.05;
constexpr double kPressDepth = 0.002;
constexpr int kEditTick = 350;
constexpr int kTicks = kEditTick + 400;
constexpr double kMaxRatio = 1.1;
constexpr double kMaxExtra_N = 0.05;

/// So fine that facets alone turn three times the force by less than a hand notices.
constexpr int kFine = 192;

std::shared_ptr<const CollisionMesh> ball(int n, double radius = kBallRadius) {
  return shapes::sphere(radius, n).build();
}

/// The same for every method.
struct Surfaces {
  std::shared_ptr<const CollisionMesh> ball = eval::ball(kFine);
  std::shared_ptr<const CollisionMesh> coarser = eval::ball(kFine / 2);
  std::shared_ptr<const CollisionMesh> finer = eval::ball(kFine + 32);
  std::shared_ptr<const CollisionMesh> larger = eval::ball(kFine, kBallRadius + 0.002);
  std::shared_ptr<const CollisionMesh> block = shapes::box(Vec3(0.03), 4).build();
};
const Surfaces& surfaces() {
  static const Surfaces all;
  return all;
}

/// Down onto the ball at 100 mm/s, then along a great circle at 20 mm/s.
struct Stroke {
  Quat from;

  /// Turns the z axis to the way from the ball's middle to the hand.
  [[nodiscard]] Quat up(int tick) const {
    return from * glm::angleAxis(0.02 * kPeriod_s / kBallRadius * std::max(0, tick - 250), Vec3(0, 1, 0));
  }
  [[nodiscard]] Vec3 hip(int tick) const {
    const double height = std::max(0.02 - 0.1 * kPeriod_s * tick, -kPressDepth + 0.0003 * std::sin(0.02 * tick));
    return up(tick) * Vec3(0, 0, kBallRadius + height);
  }
};

/// What an edit makes of the scene: of body 0, the ball that is stroked.
struct Edit {
  const char* name;
  void (*apply)(Stage& stage, Quat up, Random random);  ///< `up`: the stroke's. May be null.
  double spring_N_per_m = kSpring_N_per_m;
};

constexpr std::array kEdits{
    Edit{"stiffer", nullptr, 2500},
    Edit{"softer", nullptr, 200},
    Edit{"moved",
         [](Stage& stage, Quat, Random random) {
           stage.move(0, {glm::angleAxis(0.02, random.direction()), random.direction() * 0.002});
         }},
    Edit{"moved_far",
         [](Stage& stage, Quat up, Random) {
           stage.move(0, {{1, 0, 0, 0}, up * Vec3(0, 0, -0.2)});
         }},
    Edit{"removed", [](Stage& stage, Quat, Random) { stage.remove(0); }},
    Edit{"remeshed_coarser", [](Stage& stage, Quat, Random) { stage.replace(0, surfaces().coarser); }},
    Edit{"remeshed_finer", [](Stage& stage, Quat, Random) { stage.replace(0, surfaces().finer); }},
    Edit{"reshaped", [](Stage& stage, Quat, Random) { stage.replace(0, surfaces().larger); }},
    Edit{"covered",
         [](Stage& stage, Quat up, Random) {
           stage.add(surfaces().block, {up, up * Vec3(0, 0, kBallRadius - 0.012)});
         }},
};

struct Watched {
  double step_N = 0;  ///< Of the force, largest from the edit on.
  double work_J = 0;  ///< On the hand.
  Vec3 last_N{0};
  int nans = 0;
};

class Watch {
 public:
  void see(const Felt& felt, Vec3 hip, bool counts) {
    if (!isFinite(felt.force_N)) ++watched_.nans;
    if (counts) {
      watched_.step_N = std::max(watched_.step_N, glm::distance(felt.force_N, watched_.last_N));
      watched_.work_J += glm::dot(watched_.last_N, hip - hip_);
    }
    watched_.last_N = felt.force_N;
    hip_ = hip;
  }
  [[nodiscard]] const Watched& watched() const { return watched_; }

 private:
  Watched watched_;
  Vec3 hip_{0};
};

/// One stroke; the edit comes before tick `editAt`, never when it is negative, or has always been made when it is 0.
Watched stroke(Stage stage, const Stroke& path, const Edit& edit, int editAt, Random random) {
  stage.add(surfaces().ball);
  const auto apply = [&](Vec3 hip) {
    if (edit.apply != nullptr) edit.apply(stage, path.up(kEditTick - 1), random);
    stage.edit(hip, edit.spring_N_per_m);
  };
  stage.begin(path.hip(0));
  Watch watch;
  for (int tick = 1; tick < kTicks; ++tick) {
    if (tick == std::max(editAt, 1) && editAt >= 0) apply(path.hip(tick - 1));
    watch.see(stage.tick(path.hip(tick)), path.hip(tick), tick >= kEditTick);
  }
  return watch.watched();
}

/// A block comes to be where a HIP stands still in free space, 3 mm under its top: added, or moved there.
Watched putOnStillHip(Stage stage, bool moved) {
  const Pose there{{1, 0, 0, 0}, {0.001, 0.002, kPressDepth + 0.001 - 0.015}};
  if (moved) stage.add(surfaces().block, {{1, 0, 0, 0}, {0, 0, -0.3}});
  stage.begin(Vec3(0));
  Watch watch;
  for (int tick = 1; tick < kTicks; ++tick) {
    if (tick == kEditTick) {
      if (moved) {
        stage.move(0, there);
      } else {
        stage.add(surfaces().block, there);
      }
      stage.edit(Vec3(0));
    }
    watch.see(stage.tick(Vec3(0)), Vec3(0), tick >= kEditTick);
  }
  return watch.watched();
}

/// A block falls 5 mm onto a HIP that stands still and stops 2 mm farther. No edit, but a step all the same: the largest
/// difference (N) between the force and that of a spring as long as the HIP is deep.
double dropOnStillHip(Stage stage) {
  constexpr double kGravity_m_per_s2 = 9.81;
  constexpr double kCubeHalf_m = 0.015;
  const auto bottomAt = [](double z) { return Pose{{1, 0, 0, 0}, {0.001, 0.002, z + kCubeHalf_m}}; };
  stage.add(surfaces().block, bottomAt(0.005));
  stage.begin(Vec3(0));
  double worst_N = 0;
  for (int tick = 1; tick < 60; ++tick) {
    const double time_s = tick * kPeriod_s;
    const double bottom = std::max(0.005 - 0.5 * kGravity_m_per_s2 * time_s * time_s, -kPressDepth);
    stage.move(0, bottomAt(bottom));
    const Vec3 ideal_N(0, 0, kSpring_N_per_m * std::min(bottom, 0.0));
    worst_N = std::max(worst_N, glm::distance(stage.tick(Vec3(0)).force_N, ideal_N));
  }
  return worst_N;
}

}  // namespace

/// Each edit is to be felt in the end as if the scene had always been so, and on the way there the force is to take no
/// larger step than without the edit, but for what a hand does not notice. Under a HIP that stands still the force takes
/// no step at all, whatever the shapes.
SceneResult editUnderTheHand(Renderer& method, Random& random) {
  constexpr double kSame_N = 0.1;
  SceneResult result;
  double excess_N = -std::numeric_limits<double>::infinity();
  double drift_J = 0;
  int nans = 0;
  int unfelt = 0;
  const Stage stage(method, random);
  const Stroke path{random.rotation()};
  const Random own(static_cast<std::uint64_t>(random.below(1 << 30)));
  const auto judge = [&](const char* name, const Watched& with, double without_N, Vec3 expected_N) {
    result.measures[std::string(name) + "_force_step_N"] = with.step_N;
    excess_N = std::max(excess_N, with.step_N - (kMaxRatio * without_N + kMaxExtra_N));
    nans += with.nans;
    unfelt += glm::distance(with.last_N, expected_N) <= kSame_N ? 0 : 1;
  };
  const Watched without = stroke(stage, path, {"", nullptr}, -1, own);
  result.measures["unedited_force_step_N"] = without.step_N;
  for (const Edit& edit : kEdits) {
    const Watched with = stroke(stage, path, edit, kEditTick, own);
    const Watched always = stroke(stage, path, edit, 0, own);
    judge(edit.name, with, without.step_N, always.last_N);
    drift_J = std::max(drift_J, std::abs(with.work_J - without.work_J));
  }
  const Vec3 pushed_N(0, 0, kSpring_N_per_m * (kPressDepth + 0.001));
  judge("put_on_still_hip", putOnStillHip(stage, false), 0, pushed_N);
  judge("moved_on_still_hip", putOnStillHip(stage, true), 0, pushed_N);
  const double dropped_N = dropOnStillHip(stage);
  result.measures["dropped_on_still_hip_force_error_N"] = dropped_N;
  result.measures["excess_force_step_N"] = excess_N;
  result.measures["energy_drift_mJ"] = drift_J * 1e3;
  result.measures["nan_ticks"] = nans;
  result.measures["edits_not_felt"] = unfelt;
  const bool restingPass = editUnderRestingHip(method, random, result);
  result.pass = excess_N <= 0 && dropped_N <= kMaxExtra_N && nans == 0 && unfelt == 0 && restingPass;
  return result;
}

}  // namespace haptics::eval
