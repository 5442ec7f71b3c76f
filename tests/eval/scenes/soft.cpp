// Surfaces that yield: S16.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "haptic_server/engine/geometry/closest_point.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kRadius_m = 0.05;
constexpr int kSegments = 20;  // along the edges of a cube: 4,800 triangles
/// Deeper than its facets lie below the sphere, so that the hand is in the mesh.
constexpr double kInMesh_m = 5e-4;
constexpr double kMaxError_m = 1e-4;
/// Along a smooth pad: what a hand does not feel beside a press of some newtons.
constexpr double kMaxRipple_N = 0.01;

struct Outcome {
  int insideTicks = 0;
  int falseExits = 0;   ///< Ticks inside of the shape at rest without a contact, though the tissue is elastic.
  int outrunTicks = 0;  ///< In which the surface moved more than the HIP was below it: that the scene is what it says.
  int inverted = 0;     ///< Triangles turned over, over all ticks.
  int nonFinite = 0;
  double error_m = 0;  ///< By which the dented mesh is nearer to the HIP than the IHIP.
};

/// Over all triangles of the dented mesh.
class DentedMesh {
 public:
  DentedMesh(const shapes::Shape& rest, std::span<const Dent> dents, const Falloff& falloff) : rest_(rest) {
    now_.reserve(rest.vertices.size());
    for (const Vec3f v : rest.vertices) now_.push_back(dented(v, dents, falloff));
  }

  [[nodiscard]] int inverted() const {
    int count = 0;
    for (const auto& t : rest_.triangles) count += glm::dot(normal(rest_.vertices, t), normal(now_, t)) > 0 ? 0 : 1;
    return count;
  }

  [[nodiscard]] double distance_m(Vec3 from) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& t : rest_.triangles) {
      TriangleRecord r{};
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t d = 0; d < 3; ++d) r.rows[d][k] = now_[t[k]][static_cast<int>(d)];
      }
      nearest = std::min(nearest, closestOn(r, 0, from).squaredDistance);
    }
    return std::sqrt(nearest);
  }

 private:
  template <class Triangle>
  static Vec3 normal(const std::vector<Vec3f>& vertices, const Triangle& t) {
    const Vec3 a(vertices[t[0]]);
    return glm::cross(Vec3(vertices[t[1]]) - a, Vec3(vertices[t[2]]) - a);
  }

  const shapes::Shape& rest_;
  std::vector<Vec3f> now_;
};

/// Presses and lets go, `deepest_m` at `rate_Hz`, while it slides around the sphere.
void press(Renderer& method, Random& random, const SoftTissue& tissue, double deepest_m, double rate_Hz,
           Outcome& outcome) {
  constexpr int kSoftTicks = 1500;
  constexpr int kLookedAt = 10;  // every so many ticks
  const shapes::Shape sphere = shapes::sphere(kRadius_m, kSegments);
  FeltSurface surface;
  surface.device.maxForce_N = 1e9;
  surface.tissue = tissue;
  method.setSurfaceProperties(surface);
  Stage stage(method, random);
  stage.add(sphere);
  const double slide_per_tick = random.between(0, 2e-4);
  const double phase = random.between(0, 1);
  const auto hipAt = [&](int i) {
    const double angle = slide_per_tick * i;
    const double wave = std::sin(2 * std::numbers::pi * (rate_Hz * kPeriod_s * i));
    return (kRadius_m + kInMesh_m - deepest_m * wave) * Vec3(std::sin(angle), 0.2 * phase, std::cos(angle)) /
           std::sqrt(1 + 0.04 * phase * phase);
  };
  stage.begin(hipAt(0) * 1.1);
  Vec3 lastIhip(0);
  bool touched = false;
  for (int i = 0; i < kSoftTicks; ++i) {
    const Vec3 hip = hipAt(i);
    const Felt felt = stage.tick(hip);
    const double depth_m = kRadius_m - glm::length(hip);
    const bool inside = depth_m > kInMesh_m;
    outcome.nonFinite += isFinite(felt.force_N) && isFinite(felt.ihip) ? 0 : 1;
    outcome.insideTicks += inside;
    outcome.falseExits += inside && !felt.touching && tissue.returnTime_s == 0;
    const double below_m = glm::distance(felt.ihip, hip);
    outcome.outrunTicks += touched && felt.touching && glm::distance(felt.ihip, lastIhip) > below_m;
    lastIhip = felt.ihip;
    touched = felt.touching;
    if (i % kLookedAt != 0) continue;
    const std::vector<Dent> dents = method.dents(0);
    const DentedMesh mesh(sphere, dents, tissue.falloff);
    outcome.inverted += mesh.inverted();
    if (felt.touching) outcome.error_m = std::max(outcome.error_m, below_m - mesh.distance_m(hip));
  }
}

/// Rubs a flat pad that is smooth for the hand. Largest force along it, N: the pad is without friction.
double ripple_N(Renderer& method, Random& random) {
  constexpr double kPad_m = 0.1;
  constexpr int kEdges = 50;
  constexpr int kDown = 300, kSoftTicks = 900;
  FeltSurface surface;
  surface.device.maxForce_N = 1e9;
  surface.tissue = SoftTissue{Falloff(0.02, 2), 400, 0};
  surface.properties.shading = Shading{.crease_rad = 0.5, .creases = {}};
  method.setSurfaceProperties(surface);
  Stage stage(method, random);
  stage.add(shapes::box(Vec3(kPad_m), kEdges));
  const double way = random.between(0, 2 * std::numbers::pi);
  const double depth_m = random.between(0.002, 0.007);
  const double speed_m_per_tick = random.between(0.5e-4, 1.5e-4);
  const auto hipAt = [&](int i) {
    const double along = speed_m_per_tick * (std::max(i - kDown, 0) - (kSoftTicks - kDown) / 2);
    const double deep = std::min(1.0, static_cast<double>(i) / kDown) * (depth_m + 0.001);
    return Vec3(along * std::cos(way), along * std::sin(way), kPad_m / 2 + 0.001 - deep);
  };
  stage.begin(hipAt(0));
  double most_N = 0;
  for (int i = 1; i < kSoftTicks; ++i) {
    const Vec3 force_N = stage.tick(hipAt(i)).force_N;
    if (i > kDown) most_N = std::max(most_N, std::hypot(force_N.x, force_N.y));
  }
  return most_N;
}

}  // namespace

SceneResult yieldToTheHand(Renderer& method, Random& random) {
  Outcome outcome;
  // Soft tissue, which goes nearly all of the way; stiffer; deeper than the tissue can give; viscous.
  press(method, random, {Falloff(0.02, 2), 20, 0}, 0.004, random.between(15, 40), outcome);
  press(method, random, {Falloff(0.02, 3), 500, 0}, 0.003, random.between(15, 40), outcome);
  press(method, random, {Falloff(0.01, 2), 50, 0}, 0.012, random.between(4, 8), outcome);
  press(method, random, {Falloff(0.02, 2), 100, 0.05}, 0.004, random.between(3, 10), outcome);
  const double ripple = ripple_N(method, random);
  SceneResult result;
  result.measures = {{"inside_ticks", outcome.insideTicks},
                     {"outrun_ticks", outcome.outrunTicks},
                     {"false_exit_ticks", outcome.falseExits},
                     {"inverted_triangles", outcome.inverted},
                     {"non_finite_ticks", outcome.nonFinite},
                     {"contact_error_mm", 1e3 * outcome.error_m},
                     {"ripple_N", ripple}};
  result.pass = outcome.falseExits == 0 && outcome.inverted == 0 && outcome.nonFinite == 0 &&
                outcome.error_m < kMaxError_m && outcome.outrunTicks > 0 && ripple <= kMaxRipple_N;
  return result;
}

}  // namespace haptics::eval
