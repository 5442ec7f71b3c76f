// viewer_frame_cost [SPHERES [FRAMES [PICTURE]]]: processor time of a frame while the simulated contact dents soft spheres.
// viewer_frame_cost turn: of a frame in which the camera moves around a million triangles. Figures, not tests.

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include "common/clock/monotonic.h"
#include "common/mesh/generators.h"
#include "graphics_client/viewer/scene_view.h"
#include "graphics_client/viewer/viewer.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace {

using namespace haptics;

constexpr std::uint32_t kSegments = 73;  // 63,948 triangles
constexpr double kRadius_m = 0.05;
constexpr int kWarmUp = 75;  // all positions of the stroke, and the building of the render mesh

double processorTime_s() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(use.ru_utime) + seconds(use.ru_stime);
}

/// Spheres in a row, the first of which is stroked to and fro.
class StrokedSpheres {
 public:
  explicit StrokedSpheres(int count) {
    SurfaceProperties shaded;
    shaded.shading = Shading{.crease_rad = 1, .creases = {}};
    for (int i = 0; i < count; ++i) {
      const ObjectId id = mirror_.add("sphere" + std::to_string(i), mesh_, Pose{Quat(1, 0, 0, 0), {0.12 * i, 0, 0.05}},
                                      {.red = 0.75F, .green = 0.2F, .blue = 0.16F});
      mirror_.setSurface(id, shaded);
      mirror_.setSoftness(id, Softness{.stiffness_N_per_m = 250, .radius_m = 0.022});
    }
    mirror_.touch(1, 0, 0.006);
  }

  std::shared_ptr<const MirrorView> at(double time_s) {
    const double angle = 0.5 * std::sin(2 * std::numbers::pi * time_s);
    const Vec3 out(std::sin(angle), -0.5, std::cos(angle));
    const Vec3 at = kRadius_m * glm::normalize(out), depth = -0.006 * glm::normalize(out);
    MirrorView& view = mirror_.view();
    view.dents = {{1, {Vec3f(at), Vec3f(depth)}}};
    TelemetrySample& sample = *view.sample;
    ++sample.tick;
    sample.time_ns = view.takenAt_ns = monotonicNow_ns();
    sample.primitive = {.kind = PrimitiveKind::kPolygon, .localIndex = 0, .polygon = nearestTo(at)};
    sample.ihip = at + depth + Vec3(0, 0, 0.05);
    sample.hip = sample.ihip + 0.3 * depth;
    sample.surfaceNormal = glm::normalize(out);
    return mirror_.now();
  }

 private:
  FakeMirror mirror_;
  TriMesh mesh_ = makeSphere(kRadius_m, kSegments).value();
  std::map<int, std::uint32_t> nearest_;  // by the place's x in tenths of a millimetre: places come again

  std::uint32_t nearestTo(Vec3 place) {
    const auto [known, isNew] = nearest_.try_emplace(static_cast<int>(std::lround(place.x * 1e4)), 0U);
    if (!isNew) return known->second;
    const auto far2 = [&](const TriangleIndices& t) { return squaredLength(Vec3(mesh_.vertices[t[0]]) - place); };
    known->second =
        static_cast<std::uint32_t>(std::ranges::min_element(mesh_.triangles, {}, far2) - mesh_.triangles.begin());
    return known->second;
  }
};

/// As in a window, by the coarse copy, and by all triangles.
int turnAround() {
  constexpr int kFrames = 20;
  FakeMirror mirror;
  mirror.add("ball", makeSphere(kRadius_m, 289).value(), {}, {.red = 0.75F, .green = 0.2F, .blue = 0.16F});
  mirror.touch(1, 1000, 0.002);
  ViewerOptions options;
  options.offscreen = true;
  options.height_px = 800;
  SceneView scene(options);
  double now_s = 0;
  do {
    scene.drawFrame(mirror.now(), now_s += 0.1);
  } while (scene.objects().isSettling() || scene.isMoving());
  const auto cost_ms = [&](const std::function<void()>& draw) {
    double before_s = 0;
    for (int frame = -1; frame < kFrames; ++frame) {  // the first one hands the triangles over
      if (frame == 0) before_s = processorTime_s();
      scene.cameras().orbit(5, 0);
      now_s += 0.02;
      draw();
    }
    return 1e3 * (processorTime_s() - before_s) / kFrames;
  };
  const double all_ms = cost_ms([&] { static_cast<void>(scene.wholeFrame(mirror.now(), now_s)); });
  const double coarse_ms = cost_ms([&] { scene.drawFrame(mirror.now(), now_s); });
  std::printf(
      "1,002,252 triangles, 1280x800, the camera moves: %.1f ms of processor time a frame, %.1f with all of them\n",
      coarse_ms, all_ms);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "turn") return turnAround();
  const int spheres = argc > 1 ? std::atoi(argv[1]) : 1;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 100;
  StrokedSpheres scene(spheres);
  ViewerOptions options;
  options.offscreen = true;
  options.frameLimit_Hz = 1000;
  if (argc > 3) options.screenshot = argv[3];
  std::atomic<bool> stop{false};
  int frame = 0;
  double before_s = 0;
  std::uint64_t before_ns = 0;
  const auto summary = runOffscreen(
      options,
      [&] {
        if (frame == kWarmUp) {
          before_s = processorTime_s();
          before_ns = monotonicNow_ns();
        }
        if (frame++ == kWarmUp + frames) {
          const double wall_ms = 1e-6 * static_cast<double>(monotonicNow_ns() - before_ns);
          std::printf("%d sphere(s) of 63,948 triangles: %.1f ms of processor time a frame, %.1f ms in all\n", spheres,
                      1e3 * (processorTime_s() - before_s) / frames, wall_ms / frames);
          stop = true;
        }
        return scene.at(frame / 60.0);
      },
      stop);
  return summary ? 0 : 1;
}
