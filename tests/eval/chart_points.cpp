#include "tests/eval/chart_points.h"

#include <cstdio>

#include "tests/eval/accuracy_run.h"
#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/statistics.h"

namespace haptics::eval {
namespace {

constexpr double kDepth_m = 0.002;
constexpr double kStep_m = 1e-4;  // 0.1 m/s at 1 kHz
constexpr int kColdTicks = 12;    // on each shape: a sweep takes some 10 ms
constexpr int kCountedTicks = 20;

struct Way {
  std::vector<Vec3> down;
  std::vector<Vec3> stroke;  ///< As far as it is in contact.
};

Way wayOn(const AnalyticShape& shape) {
  constexpr double kLift_m = 0.002;
  Way way;
  for (double below = -kLift_m; below < kDepth_m; below += kStep_m) way.down.push_back(shape.at(0, below).hip);
  for (double s = 0; s <= kPath_m; s += kStep_m) {
    const Truth truth = shape.at(s, kDepth_m);
    if (!truth.touching) break;
    way.stroke.push_back(truth.hip);
  }
  return way;
}

/// One method on the shapes, as they come.
class Measured {
 public:
  explicit Measured(const Method& method) : method_(method) {}

  void add(const Sample& sample, std::uint64_t seed) {
    if (stopped_) return;
    Record why;
    stopped_ = !runOrExplain(why, [&] { measure(sample, seed); });
    if (stopped_) std::printf("%s %s: %s\n", method_.name.data(), sample.shape.name.data(), measuresText(why).c_str());
  }

  [[nodiscard]] bool stopped() const { return stopped_; }
  [[nodiscard]] ChartPoint pointAt(int triangles) {
    return {std::string(method_.name), triangles, epsilon_,
            above100Hz_rms_N_,         rest_,     {hot_.quantile(0.5), cold_.quantile(0.5), instructions_}};
  }

 private:
  void measure(const Sample& sample, std::uint64_t seed) {
    const Record record = measureAccuracy(method_, sample, kDepth_m, seed, false);
    epsilon_ = std::max(epsilon_, record["epsilon_p99_ratio"].get<double>());
    above100Hz_rms_N_ = std::max(above100Hz_rms_N_, record["force_above_100Hz_rms_N"].get<double>());
    const ClosedLoopRest rest = restOnMesh(method_, sample);
    if (rest.limitCycle_um >= rest_.limitCycle_um) rest_ = rest;
    const Way way = wayOn(sample.shape);
    const bool first = hot_.empty();
    const InstructionCost price =
        instructionCostOf(*method_.make(), sample.surface, way.down, way.stroke, kColdTicks, first ? kCountedTicks : 0);
    hot_.add(price.hot_ns);
    cold_.add(price.cold_ns);
    if (first) instructions_ = price.instructions;
  }

  const Method& method_;
  bool stopped_ = false;
  double epsilon_ = 0;
  double above100Hz_rms_N_ = 0;
  ClosedLoopRest rest_;
  double instructions_ = 0;
  Statistics hot_;
  Statistics cold_;
};

void print(const ChartPoint& p) {
  std::printf(
      "%8d triangles  %-25s hot %8.1f ns  cold %8.0f ns  %8.0f instructions  epsilon %8.3f  %.4f N  cycle %.1f um\n",
      p.triangles, p.method.c_str(), p.price.hot_ns, p.price.cold_ns, p.price.instructions, p.epsilon,
      p.above100Hz_rms_N, p.rest.limitCycle_um);
}

}  // namespace

std::vector<ChartPoint> measureChartPoints(std::span<const Method> methods, std::uint64_t seed, int finest) {
  std::vector<ChartPoint> points;
  for (const int triangles : kMeshTriangles) {
    if (triangles > finest) break;
    std::vector<Measured> all(methods.begin(), methods.end());
    for (const AnalyticShape& shape : analyticShapes()) {  // one at a time: 10 million triangles take a gigabyte
      const Sample sample = makeSample(shape, triangles);
      for (Measured& measured : all) measured.add(sample, seed);
    }
    for (Measured& measured : all) {
      if (measured.stopped()) continue;
      points.push_back(measured.pointAt(triangles));
      print(points.back());
    }
    std::fflush(stdout);
  }
  return points;
}

Outcome outcomeOf(const Method& method, std::uint64_t seed) {
  Outcome outcome;
  for (const FailureScene& scene : kFailureScenes) {
    if (!method.isFor(scene.concern)) continue;
    Record verdict;
    runOrExplain(verdict, [&] {
      Random random = scene.random(seed);
      verdict["pass"] = scene.run(*method.make(), random).pass;
    });
    if (!verdict["pass"].is_null()) (verdict["pass"] ? outcome.passed : outcome.failed).push_back(scene.name);
  }
  return outcome;
}

}  // namespace haptics::eval
