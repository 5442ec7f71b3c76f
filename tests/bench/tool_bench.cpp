#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/engine/tool/tool_contact.h"
#include "tests/bench/benches.h"
#include "tests/bench/stopwatch.h"
#include "tests/eval/baselines/distance_field_shell.h"

namespace haptics::bench {
namespace {

/// How a tool is moved over the torus, and what is near it meanwhile.
struct ToolMotion {
  const char* name;
  Vec3 semiAxes_m;  // of the ellipsoid
  double lowest_m;  // of its centre, over the torus' plane
};
constexpr ToolMotion kBlunt{"blunt", {0.010, 0.010, 0.030}, 0.042};  // 8 mm deep, some 100 points below the surface
constexpr ToolMotion kFlat{"flat", {0.030, 0.030, 0.004}, 0.016};    // rests on the top of the ring

constexpr int kTicks = 6'000;  // of 1 ms
constexpr int kRounds = 5;     // in which the same ticks come again
constexpr ToolCoupling kCoupling{.stiffness_N_per_m = 800, .torsion_Nm_per_rad = 2};

/// Pressed into the torus, slid along it and turned.
[[nodiscard]] Pose poseAt(const ToolMotion& motion, double time_s) {
  const double z = std::max(motion.lowest_m, motion.lowest_m + 0.018 - 0.02 * time_s);
  const Quat turned = glm::angleAxis(0.3 * std::sin(2.5 * time_s), glm::normalize(Vec3(1, 0.5, 0.2)));
  return {turned, Vec3(0.05 + 0.01 * std::sin(3 * time_s), 0.012 * std::sin(2 * time_s), z)};
}

[[nodiscard]] ToolShell ellipsoid(Vec3 semiAxes_m, int points) {
  ToolShell shell;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < points; ++i)
    shell.points.push_back(glm::normalize(Vec3(normal(random), normal(random), normal(random))) * semiAxes_m);
  shell.radius_m = std::max({semiAxes_m.x, semiAxes_m.y, semiAxes_m.z});
  return shell;
}

/// The deepest of a tool's points below a closed surface, m.
[[nodiscard]] double deepest(const ToolShell& shell, const Pose& pose, const CollisionMesh& surface) {
  double depth = 0;
  for (const Vec3& point : shell.points) {
    const Vec3 at = toWorld(pose, point);
    int looked = 0;
    const ClosestPoint foot = surface.closestFoot(at, 1 << 20, looked);
    if (!surface.isOutside(foot, at)) depth = std::max(depth, std::sqrt(foot.squaredDistance));
  }
  return depth;
}

/// Made once.
const std::shared_ptr<const CollisionMesh>& torusOf(std::uint32_t segments) {
  static std::map<std::uint32_t, std::shared_ptr<const CollisionMesh>> made;
  std::shared_ptr<const CollisionMesh>& surface = made[segments];
  if (surface == nullptr) {
    const TriMesh torus = makeTorus(0.05, 0.02, segments, segments / 2).value();
    surface = buildCollisionMesh(torus.vertices, torus.triangles, 2);
  }
  return surface;
}

struct BuiltField {
  eval::DistanceField field;
  double build_s;  ///< Of one processor.
};

/// Likewise.
const BuiltField& fieldOf(std::uint32_t segments, int cells) {
  constexpr double kMargin_m = 0.005;
  static std::map<std::pair<std::uint32_t, int>, BuiltField> made;
  const auto found = made.find({segments, cells});
  if (found != made.end()) return found->second;
  const std::clock_t begun = std::clock();
  eval::DistanceField field(*torusOf(segments), cells, kMargin_m);
  const double build_s = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  return made.emplace(std::pair(segments, cells), BuiltField{std::move(field), build_s}).first->second;
}

/// Leads a tool along the motion, round by round: follow(device) is what takes its time, and returns where it is. Of each
/// tick the least counts that it took in any round: a machine that others share holds one in a hundred up, for longer than
/// the dearest takes; p50_shared_ns and p99_shared_ns are of all ticks as they were.
template <class Follow>
void leadTool(benchmark::State& state, const ToolMotion& motion, const ToolShell& shell, const CollisionMesh& surface,
              Follow follow) {
  constexpr std::size_t kJudgedEvery = 500;  // seldom: the tick after it finds the caches cold
  Stopwatch stopwatch;
  std::vector<double> least_ns(kTicks, std::numeric_limits<double>::infinity()), all_ns;
  double deepest_m = 0;
  std::size_t tick = 0;
  for (auto _ : state) {
    Pose proxy;
    double& least = least_ns[tick % kTicks];
    const Pose device = poseAt(motion, 1e-3 * static_cast<double>(tick++ % kTicks));
    all_ns.push_back(stopwatch.time([&] { proxy = follow(device); }));
    least = std::min(least, all_ns.back());
    state.SetIterationTime(1e-9 * all_ns.back());
    if (tick % kJudgedEvery == 0) deepest_m = std::max(deepest_m, deepest(shell, proxy, surface));
  }
  state.counters["p50_ns"] = percentile(least_ns, 0.5);
  state.counters["p99_ns"] = percentile(least_ns, 0.99);
  state.counters["worst_ns"] = percentile(least_ns, 1);
  state.counters["p50_shared_ns"] = percentile(all_ns, 0.5);
  state.counters["p99_shared_ns"] = percentile(all_ns, 0.99);
  state.counters["deepest_um"] = 1e6 * deepest_m;
}

void tickOfATool(benchmark::State& state, const ToolMotion& motion, std::uint32_t segments, int points) {
  const auto& surface = torusOf(segments);
  Body body;
  body.surface = surface.get();
  body.update();
  const std::span<const Body> bodies(&body, 1);
  const TriMesh ball = makeSphere(1, 8).value();  // whose points are the ellipsoid's own
  const Tool held{buildCollisionMesh(ball.vertices, ball.triangles), ellipsoid(motion.semiAxes_m, points)};
  const auto tool = std::make_unique<StandaloneTool>();
  tool->hold(held);
  tool->adopt(std::array{ToolContact::Obstacle{body.current, {}, -1}});
  tool->reset(poseAt(motion, 0), bodies);
  double touching = 0, waits = 0;
  leadTool(state, motion, held.shell, *surface, [&](const Pose& device) {
    const ToolResult result = tool->follow(bodies, device, kCoupling);
    touching += tool->touching();
    waits += result.waits ? 1 : 0;
    return result.proxy;
  });
  state.counters["touching"] = touching / (kRounds * kTicks);
  state.counters["waits"] = waits;
}

/// The same motion of a point shell over a distance field (eval::DistanceFieldShell).
void tickOverAField(benchmark::State& state, const ToolMotion& motion, std::uint32_t segments, int points, int cells) {
  const ToolShell shell = ellipsoid(motion.semiAxes_m, points);
  const auto& [field, build_s] = fieldOf(segments, cells);
  state.counters["build_s"] = build_s;
  state.counters["field_MB"] = 1e-6 * static_cast<double>(field.bytes());
  eval::DistanceFieldShell tool(shell, field, kCoupling);
  tool.reset(poseAt(motion, 0));
  double touching = 0;
  leadTool(state, motion, shell, *torusOf(segments), [&](const Pose& device) {
    const Pose pose = tool.follow(device);
    touching += tool.touching();
    return pose;
  });
  state.counters["touching"] = touching / (kRounds * kTicks);
}

}  // namespace

void registerTools() {
  constexpr std::uint32_t kCoarse = 256;
  for (const ToolMotion& motion : {kBlunt, kFlat}) {
    for (const std::uint32_t segments : {kCoarse, 1024U}) {
      for (const int points : {1, 100, 1'000, 4'000}) {
        const std::string of = std::string("/hot/") + motion.name + "/" + std::to_string(points) + "_points/" +
                               std::to_string(segments * segments) + "_triangles";
        benchmark::RegisterBenchmark(("tool_tick" + of).c_str(), tickOfATool, motion, segments, points)
            ->UseManualTime()
            ->Iterations(kRounds * kTicks);
        if (segments != kCoarse) continue;  // a field does not know of how many triangles it was made
        for (const int cells : {128, 256}) {
          const std::string name = "field_tick" + of + "/" + std::to_string(cells) + "_cells";
          benchmark::RegisterBenchmark(name.c_str(), tickOverAField, motion, segments, points, cells)
              ->UseManualTime()
              ->Iterations(kRounds * kTicks);
        }
      }
    }
  }
}

}  // namespace haptics::bench
