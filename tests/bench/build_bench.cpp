#include <benchmark/benchmark.h>

#include <string>

#include "tests/bench/benches.h"
#include "tests/bench/scenes.h"

namespace haptics::bench {
namespace {

/// The tree alone.
void hierarchy(benchmark::State& state, std::uint32_t segments, int threads) {
  const TriMesh mesh = sphereMesh(segments);
  for (auto _ : state) {
    BoundingHierarchy tree;
    benchmark::DoNotOptimize(tree.build(mesh.vertices, mesh.triangles, kRadius_m, threads));
  }
  state.counters["s_per_million_triangles"] =
      benchmark::Counter(static_cast<double>(mesh.triangles.size()) * 1e-6,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Tree, neighbours, records, normals and flags, from a mesh in canonical order.
void build(benchmark::State& state, std::uint32_t segments, int threads) {
  const TriMesh mesh = sphereMesh(segments);
  const auto triangles = static_cast<double>(mesh.triangles.size());
  std::size_t memory_bytes = 0;
  for (auto _ : state) memory_bytes = buildCollisionMesh(mesh.vertices, mesh.triangles, threads)->memory_bytes();
  state.counters["s_per_million_triangles"] =
      benchmark::Counter(triangles * 1e-6, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["bytes_per_triangle"] = static_cast<double>(memory_bytes) / triangles;
}

/// The same of a mesh that was built before and whose vertices have moved: all of them, as by a lattice, or those of a
/// dent, half the radius wide.
void refit(benchmark::State& state, std::uint32_t segments, bool all) {
  constexpr double kWidth = 0.5;
  const TriMesh mesh = sphereMesh(segments);
  const auto built = buildCollisionMesh(mesh.vertices, mesh.triangles);
  const Vec3f pole(Vec3(0, 0, built->high().z));
  std::vector<Vec3f> moved = mesh.vertices;
  for (Vec3f& v : moved) {
    if (all || glm::distance(v, pole) < kWidth * pole.z) v.z *= 0.99F;
  }
  for (auto _ : state) benchmark::DoNotOptimize(refitCollisionMesh(*built, moved));
  state.counters["s_per_million_triangles"] =
      benchmark::Counter(static_cast<double>(mesh.triangles.size()) * 1e-6,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

}  // namespace

void registerBuild(std::span<const std::uint32_t> sizes) {
  for (const std::uint32_t n : sizes) {
    for (const bool all : {true, false}) {
      const std::string refitName =
          std::string("refit/moved:") + (all ? "all" : "dent") + "/triangles:" + std::to_string(triangleCount(n));
      benchmark::RegisterBenchmark(refitName.c_str(), refit, n, all)->Unit(benchmark::kMillisecond)->UseRealTime();
    }
    for (const int threads : {1, 2}) {
      const std::string over = "/threads:" + std::to_string(threads) + "/triangles:" + std::to_string(triangleCount(n));
      const std::string treeName = "hierarchy" + over, allName = "build" + over;
      benchmark::RegisterBenchmark(treeName.c_str(), hierarchy, n, threads)
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
      benchmark::RegisterBenchmark(allName.c_str(), build, n, threads)->Unit(benchmark::kMillisecond)->UseRealTime();
    }
  }
}

}  // namespace haptics::bench
