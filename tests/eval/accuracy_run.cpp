#include "tests/eval/accuracy_run.h"

#include <numbers>
#include <optional>

#include "common/maths/perception.h"
#include "haptic_server/device/presets.h"
#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/brute_force_proxy.h"
#include "tests/eval/spectrum.h"
#include "tests/eval/stage.h"
#include "tests/eval/statistics.h"
#include "tests/eval/timing.h"

namespace haptics::eval {
namespace {

constexpr double kSpeed_m_per_s = 0.1;
constexpr double kStep_m = kSpeed_m_per_s * kPeriod_s;
constexpr double kLift_m = 0.002;  // clear of a coarse mesh, which stands above the valleys
/// Of the depth, between ours and brute force on the same mesh.
constexpr double kMaxBruteDifference = 1e-5;

double meanEdge(const TriMesh& mesh) {
  double sum = 0;
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) sum += glm::distance(mesh.vertices[t[k]], mesh.vertices[t[(k + 1) % 3]]);
  }
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

/// What the force does on the hand in a loop that begins and ends in free space.
class Work {
 public:
  void tick(Vec3 hip, Vec3 force_N) {
    const Vec3 step = hip - hip_;
    if (started_) {
      geometric_J_ += glm::dot((force_N_ + force_N) * 0.5, step);
      held_J_ -= glm::dot(force_N_, step);
      dissipated_J_ += viscousFriction_ * squaredLength(step) / kPeriod_s;
      least_J_ = std::min(least_J_, held_J_ + dissipated_J_);
    }
    hip_ = hip;
    force_N_ = force_N;
    started_ = true;
  }
  /// Of the field of forces, between ticks as if it were continuous: 0 for a conservative one.
  [[nodiscard]] double loop_J() const noexcept { return geometric_J_; }
  /// min(E_VE + sum b v^2 T), E_VE the energy that the force as held from tick to tick takes from the hand, b the
  /// viscous friction of the default device: negative when a passive device would gain energy.
  [[nodiscard]] double minEnergy_J() const noexcept { return least_J_; }

 private:
  double viscousFriction_ = findDevicePreset(kDefaultDevicePreset)->viscousFriction_Ns_per_m;
  bool started_ = false;
  Vec3 hip_{0};
  Vec3 force_N_{0};
  double geometric_J_ = 0;
  double held_J_ = 0;
  double dissipated_J_ = 0;
  double least_J_ = 0;
};

class Run {
 public:
  Run(const Method& method, const Sample& sample, double depth, std::uint64_t seed, bool compare)
      : method_(method), sample_(sample), depth_(depth), seed_(seed) {
    if (compare) brute_.emplace(sample.mesh);
  }

  [[nodiscard]] Record record() {
    const auto renderer = method_.make();
    Random random(seed_);
    Stage stage(*renderer, random);
    stage.add(sample_.surface);
    stage.begin(at(0, -kLift_m).hip);
    for (double below = -kLift_m; below < depth_; below += kStep_m) follow(stage, at(0, below));
    follow(stage, at(0, depth_));
    for (double way = kStep_m; way <= kPath_m; way += kStep_m) stroke(stage, at(way, depth_));
    for (double below = depth_; below > -kLift_m; below -= kStep_m) follow(stage, at(kPath_m, below));
    follow(stage, at(kPath_m, -kLift_m));
    time(*renderer, stage);
    return describe();
  }

 private:
  [[nodiscard]] Truth at(double way, double below) const { return sample_.shape.at(way, below); }

  /// One tick; returns where the brute-force proxy is.
  Vec3 follow(Stage& stage, const Truth& truth) {
    const bool wasTouching = felt_.touching;
    felt_ = stage.tick(truth.hip);
    hip_ = truth.hip;
    work_.tick(hip_, felt_.force_N);
    path_.push_back(stage.inWorld(hip_));
    if (!brute_ || !felt_.touching) return felt_.ihip;
    if (!wasTouching) brute_->touch(hip_);
    return brute_->follow(hip_);
  }

  void stroke(Stage& stage, const Truth& truth) {
    const Felt before = felt_;
    const double hipStep = glm::distance(truth.hip, hip_);
    const Vec3 reference = follow(stage, truth);
    forceStep_N_ = std::max(forceStep_N_, glm::distance(felt_.force_N, before.force_N));
    ihipRatio_ = std::max(ihipRatio_, glm::distance(felt_.ihip, before.ihip) / hipStep);
    if (felt_.touching) {
      bruteDifference_ =
          std::max(bruteDifference_, glm::distance(reference, felt_.ihip) / glm::distance(reference, hip_));
    }
    triangles_.add(felt_.triangles);
    compareWith(truth, stage.depthInside(truth.hip) > kInside_m);
  }

  void compareWith(const Truth& truth, bool inside) {
    const Vec3 ideal_N = kSpring_N_per_m * (truth.ihip - truth.hip);
    ihip_.add(glm::distance(felt_.ihip, truth.ihip) * 1e3);
    force_.add(glm::distance(felt_.force_N, ideal_N));
    if (felt_.touching && truth.touching) direction_.add(angle_deg(felt_.force_N, ideal_N));
    epsilon_.add(forceError_jnd(felt_.force_N, ideal_N));
    forceErrors_N_.push_back(felt_.force_N - ideal_N);
    ++ticks_;
    outside_ += truth.touching && !inside ? 1 : 0;
    missed_ += inside && !felt_.touching ? 1 : 0;
    ghost_ += !truth.touching && felt_.touching ? 1 : 0;
    wrongSide_ += glm::dot(felt_.force_N, ideal_N) < 0 ? 1 : 0;
  }

  /// The same ticks again, for the time that they take; and once more for whether each would have been in time.
  void time(Renderer& renderer, const Stage& stage) {
    renderer.contactOnly();
    renderer.place(path_.front());
    Stopwatch stopwatch;
    for (const Vec3 hip : path_) {
      stopwatch.time([&] { (void)renderer.tick(stage.poses(), hip); });
      if (const auto own = ownTime_ns(renderer)) tick_ns_.add(*own);
    }
    if (tick_ns_.empty()) {
      tick_ns_ = stopwatch.durations_ns();
    } else {
      pipe_ns_ = stopwatch.durations_ns().quantile(0.5) - tick_ns_.quantile(0.5);
    }

    renderer.place(path_.front());
    for (const Vec3 hip : path_) {
      const double begin_s = threadTime_s();
      (void)renderer.tick(stage.poses(), hip);
      const auto own = ownTime_ns(renderer);
      deadlineMisses_ += (own ? *own * 1e-9 : threadTime_s() - begin_s) > kPeriod_s ? 1 : 0;
    }
  }

  [[nodiscard]] Record describe() {
    const double edge = meanEdge(sample_.mesh);
    Record record{{"method", method_.name},
                  {"scene", sample_.shape.name},
                  {"seed", seed_},
                  {"triangles", sample_.mesh.triangles.size()},
                  {"mean_edge_mm", edge * 1e3},
                  {"depth_mm", depth_ * 1e3},
                  {"ticks", ticks_}};
    writeErrors(record, "ihip_error", "mm", ihip_);
    writeErrors(record, "force_error", "N", force_);
    writeErrors(record, "direction_error", "deg", direction_);
    writeErrors(record, "epsilon", "ratio", epsilon_);
    if (const double radius = sample_.shape.radius_m; radius > 0) {  // of the facets alone, for edges all alike
      record["faceting_bound_force_N"] = kSpring_N_per_m * edge * edge / (6 * radius);
      record["faceting_bound_direction_deg"] = edge / (std::sqrt(3) * radius) * 180 / std::numbers::pi;
    }
    record["force_above_100Hz_rms_N"] = rmsAbove(kFeltArtefactsFrom_Hz, forceErrors_N_, kPeriod_s);
    record["force_step_max_N"] = forceStep_N_;
    record["ihip_step_per_hip_step_max_ratio"] = ihipRatio_;
    record["loop_work_mJ"] = work_.loop_J() * 1e3;
    record["energy_least_mJ"] = work_.minEnergy_J() * 1e3;
    record["outside_of_mesh_ticks"] = outside_;  // inside of the true shape, outside of the mesh inscribed in it
    record["missed_contact_ticks"] = missed_;
    record["ghost_contact_ticks"] = ghost_;
    record["wrong_side_ticks"] = wrongSide_;
    record["triangles_per_tick_rms"] = triangles_.rms();
    record["triangles_per_tick_max"] = triangles_.max();
    for (const auto& [key, part] : {std::pair{"p50", 0.5}, {"p99", 0.99}, {"p999", 0.999}, {"max", 1.0}}) {
      record[std::string("tick_") + key + "_ns"] = tick_ns_.quantile(part);
    }
    if (pipe_ns_) record["pipe_p50_ns"] = *pipe_ns_;  // to a method from outside and back, not in the above
    record["deadline_misses"] = deadlineMisses_;
    if (brute_) record["brute_force_difference_max_ratio"] = bruteDifference_;
    record["pass"] = missed_ == 0 && ghost_ == 0 && wrongSide_ == 0 && ihip_.max() <= std::max(depth_, edge) * 1e3 &&
                     bruteDifference_ <= kMaxBruteDifference;
    return record;
  }

  const Method& method_;
  const Sample& sample_;
  double depth_;
  std::uint64_t seed_;
  std::optional<BruteForceProxy> brute_;
  Felt felt_;
  Vec3 hip_{0};
  std::vector<Vec3> path_;  // world
  Work work_;
  Statistics ihip_;       // mm
  Statistics force_;      // N
  Statistics direction_;  // degrees, where there is a force
  Statistics epsilon_;
  std::vector<Vec3> forceErrors_N_;
  Statistics triangles_;  // looked at in a tick
  Statistics tick_ns_;
  std::optional<double> pipe_ns_;
  double bruteDifference_ = 0;
  double forceStep_N_ = 0;
  double ihipRatio_ = 0;
  int ticks_ = 0;
  int outside_ = 0;
  int missed_ = 0;
  int deadlineMisses_ = 0;  // ticks that took the thread more than a period
  int ghost_ = 0;
  int wrongSide_ = 0;
};

}  // namespace

Sample makeSample(const AnalyticShape& shape, int triangles) {
  Sample sample{shape, shape.mesh(triangles), nullptr};
  sample.surface = buildCollisionMesh(sample.mesh.vertices, sample.mesh.triangles);
  return sample;
}

Record measureAccuracy(const Method& method, const Sample& sample, double depth_m, std::uint64_t seed, bool compare) {
  return Run(method, sample, depth_m, seed, compare).record();
}

}  // namespace haptics::eval
