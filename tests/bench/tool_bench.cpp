#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/tool/tool_contact.h"
#include "tests/bench/benches.h"
#include "tests/bench/stopwatch.h"

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

void tickOfATool(benchmark::State& state, const ToolMotion& motion, std::uint32_t segments, int points) {
  const TriMesh torus = makeTorus(0.05, 0.02, segments, segments / 2).value();
  const auto surface = buildCollisionMesh(torus.vertices, torus.triangles, 2);
  Body body;
  body.surface = surface.get();
  body.update();
  const std::span<const Body> bodies(&body, 1);
  const TriMesh ball = makeSphere(1, 8).value();  // whose points are the ellipsoid's own
  const Tool held{buildCollisionMesh(ball.vertices, ball.triangles), ellipsoid(motion.semiAxes_m, points)};
  const auto contact = std::make_unique<ToolContact>();
  ToolContact& tool = *contact;
  tool.hold(held);
  tool.adopt(std::array{ToolContact::Obstacle{body.current, {}, -1}});
  tool.reset(poseAt(motion, 0), bodies);
  Stopwatch stopwatch;
  double touching = 0, waits = 0;
  int tick = 0;
  for (auto _ : state) {
    ToolResult result;
    const Pose device = poseAt(motion, 1e-3 * (tick++ % kTicks));
    state.SetIterationTime(1e-9 * stopwatch.time([&] { result = tool.follow(bodies, device, {800, 2}); }));
    touching += result.touching;
    waits += result.waits ? 1 : 0;
  }
  stopwatch.report(state);
  state.counters["touching"] = touching / kTicks;
  state.counters["waits"] = waits;
}

}  // namespace

void registerTools() {
  for (const ToolMotion& motion : {kBlunt, kFlat}) {
    for (const std::uint32_t segments : {256U, 1024U}) {
      for (const int points : {1, 100, 1'000, 4'000}) {
        const std::string name = std::string("tool_tick/hot/") + motion.name + "/" + std::to_string(points) +
                                 "_points/" + std::to_string(segments * segments) + "_triangles";
        benchmark::RegisterBenchmark(name.c_str(), tickOfATool, motion, segments, points)
            ->UseManualTime()
            ->Iterations(kTicks);
      }
    }
  }
}

}  // namespace haptics::bench
