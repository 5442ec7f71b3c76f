#include "tests/eval/accuracy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "tests/eval/analytic_shapes.h"
#include "tests/eval/brute_force_proxy.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr std::array kTriangles{768, 3072, 12288, kFinestMesh};
constexpr std::array kDepths_m{0.0005, 0.001, 0.002, 0.005};
constexpr double kPrintedDepth_m = 0.002;
constexpr double kSpeed_m_per_s = 0.1;
/// Of the depth, between ours and brute force on the same mesh.
constexpr double kMostBruteDifference = 1e-5;

class Errors {
 public:
  void add(double value) { values_.push_back(value); }
  [[nodiscard]] double max() const { return values_.empty() ? 0 : *std::max_element(values_.begin(), values_.end()); }
  /// As <key>_rms_<unit>, _p99_ and _max_; nothing when there was nothing to measure.
  void write(Record& record, const std::string& key, const std::string& unit) const {
    if (values_.empty()) return;
    std::vector<double> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    double squares = 0;
    for (const double v : sorted) squares += v * v;
    const auto count = static_cast<double>(sorted.size());
    record[key + "_rms_" + unit] = std::sqrt(squares / count);
    record[key + "_p99_" + unit] = sorted[static_cast<std::size_t>(0.99 * (count - 1))];
    record[key + "_max_" + unit] = sorted.back();
  }

 private:
  std::vector<double> values_;
};

struct Sample {
  const AnalyticShape& shape;
  TriMesh mesh;
  std::shared_ptr<const Surface> surface;
};

double meanEdge(const TriMesh& mesh) {
  double sum = 0;
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) sum += glm::distance(mesh.vertices[t[k]], mesh.vertices[t[(k + 1) % 3]]);
  }
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

double angle_deg(Vec3 a, Vec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

/// One run: presses at the path's start, then slides along it at constant depth.
class Run {
 public:
  Run(const Method& method, const Sample& sample, double depth, std::uint64_t seed)
      : method_(method),
        sample_(sample),
        depth_(depth),
        seed_(seed),
        compare_(method.name == kOurs),
        brute_(compare_ ? sample.mesh : TriMesh{}) {}

  [[nodiscard]] Record record() {
    constexpr double kStep = kSpeed_m_per_s * kPeriod_s;
    const auto renderer = method_.make();
    Random random(seed_);
    Stage stage(*renderer, random);
    stage.add(sample_.surface);
    stage.begin(hipAt(0, -kLift_m));
    for (double below = -kLift_m; below < depth_; below += kStep) follow(stage, hipAt(0, below));
    follow(stage, hipAt(0, depth_));
    for (double way = kStep; way <= kPath_m; way += kStep) {
      const Vec3 hip = hipAt(way, depth_);
      const Felt before = felt_;
      const double hipStep = glm::distance(hip, hip_);
      const Vec3 reference = follow(stage, hip);
      forceStep_N_ = std::max(forceStep_N_, glm::distance(felt_.force_N, before.force_N));
      ihipRatio_ = std::max(ihipRatio_, glm::distance(felt_.ihip, before.ihip) / hipStep);
      compareWith(sample_.shape.at(way), reference, stage.depthInside(hip) > kInside_m);
    }
    return describe();
  }

 private:
  static constexpr double kLift_m = 0.0005;

  [[nodiscard]] Vec3 hipAt(double way, double below) const {
    const SurfacePoint s = sample_.shape.at(way);
    return s.place - s.normal * below;
  }

  /// One tick; returns where the brute-force proxy is.
  Vec3 follow(Stage& stage, Vec3 hip) {
    const bool wasTouching = felt_.touching;
    felt_ = stage.tick(hip);
    hip_ = hip;
    if (!compare_ || !felt_.touching) return felt_.ihip;
    if (!wasTouching) brute_.touch(hip);
    return brute_.follow(hip);
  }

  void compareWith(const SurfacePoint& truth, Vec3 reference, bool inside) {
    const Vec3 ideal_N = truth.normal * (kSpring_N_per_m * depth_);
    ihip_.add(glm::distance(felt_.ihip, truth.place) * 1e3);
    force_.add(glm::distance(felt_.force_N, ideal_N));
    if (felt_.touching) direction_.add(angle_deg(felt_.force_N, ideal_N));
    bruteForce_ = std::max(bruteForce_, glm::distance(reference, felt_.ihip) / depth_);
    ++ticks_;
    outside_ += inside ? 0 : 1;
    missed_ += inside && !felt_.touching ? 1 : 0;
    wrongSide_ += glm::dot(felt_.force_N, ideal_N) < 0 ? 1 : 0;
  }

  [[nodiscard]] Record describe() const {
    const double edge = meanEdge(sample_.mesh);
    Record record{{"method", method_.name},
                  {"scene", sample_.shape.name},
                  {"seed", seed_},
                  {"triangles", sample_.mesh.triangles.size()},
                  {"mean_edge_mm", edge * 1e3},
                  {"depth_mm", depth_ * 1e3},
                  {"ticks", ticks_}};
    ihip_.write(record, "ihip_error", "mm");
    force_.write(record, "force_error", "N");
    direction_.write(record, "direction_error", "deg");
    record["force_step_max_N"] = forceStep_N_;
    record["ihip_step_per_hip_step_max_ratio"] = ihipRatio_;
    record["outside_of_mesh_ticks"] = outside_;  // inside of the true shape, outside of the mesh inscribed in it
    record["missed_contact_ticks"] = missed_;
    record["wrong_side_ticks"] = wrongSide_;
    if (compare_) record["brute_force_difference_max_ratio"] = bruteForce_;
    record["pass"] = missed_ == 0 && wrongSide_ == 0 && ihip_.max() <= std::max(depth_, edge) * 1e3 &&
                     bruteForce_ <= kMostBruteDifference;
    return record;
  }

  const Method& method_;
  const Sample& sample_;
  double depth_;
  std::uint64_t seed_;
  bool compare_;
  BruteForceProxy brute_;
  Felt felt_;
  Vec3 hip_{0};
  Errors ihip_;       // mm
  Errors force_;      // N
  Errors direction_;  // degrees, where there is a force
  double bruteForce_ = 0;
  double forceStep_N_ = 0;
  double ihipRatio_ = 0;
  int ticks_ = 0;
  int outside_ = 0;
  int missed_ = 0;
  int wrongSide_ = 0;
};

void print(const Record& r) {
  std::printf("%-25s %-9s %6d triangles  IHIP %.4f rms %.4f max mm  dF %.4f max N  angle %.3f rms %.3f max deg%s\n",
              r["method"].get<std::string>().c_str(), r["scene"].get<std::string>().c_str(), r["triangles"].get<int>(),
              r["ihip_error_rms_mm"].get<double>(), r["ihip_error_max_mm"].get<double>(),
              r["force_error_max_N"].get<double>(), r.value("direction_error_rms_deg", 0.0),
              r.value("direction_error_max_deg", 0.0), r["pass"].get<bool>() ? "" : "  FAIL");
}

}  // namespace

bool runAccuracy(std::uint64_t seed, int finest, const std::filesystem::path& out) {
  std::vector<Record> records;
  bool good = true;
  std::printf("depth %g mm\n", kPrintedDepth_m * 1e3);
  for (const AnalyticShape& shape : analyticShapes()) {
    for (const int triangles : kTriangles) {
      if (triangles > finest) break;
      Sample sample{shape, shape.mesh(triangles), nullptr};
      sample.surface = buildSurface(sample.mesh.vertices, sample.mesh.triangles);
      for (const Method& method : methods()) {
        for (const double depth : kDepths_m) {
          records.push_back(Run(method, sample, depth, seed).record());
          if (depth == kPrintedDepth_m) print(records.back());
          if (method.name == kOurs) good = good && records.back()["pass"].get<bool>();
        }
      }
    }
  }
  writeRecords(out, "accuracy", records);
  return good;
}

}  // namespace haptics::eval
