#include "haptic_server/simplification/probe_strokes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/interruption/interruption.h"
#include "common/maths/elementary.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"

namespace haptics {
namespace {

constexpr double kStrokePress_N = 1;
constexpr double kMaxForce_N = 2;
constexpr double kStep_m = 1e-4;
constexpr double kLongest_m = 0.02;
constexpr double kLongest_of_side = 1.0 / 8;
constexpr double kFewestSteps = 20;  // of small objects' strokes

/// From 0 to 1, the same on every machine.
double drawn(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

double areaOf(const TriMesh& mesh, const TriangleIndices& t) {
  const Vec3 a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
  return glm::length(glm::cross(b - a, c - a));
}

/// Without its end.
void addLine(ProbeStroke& stroke, Vec3 from, Vec3 to, double step_m) {
  const double steps = std::max(1.0, std::ceil(glm::distance(from, to) / step_m));
  for (double i = 0; i < steps; ++i) stroke.push_back(glm::mix(from, to, i / steps));
}

struct Measures {
  double depth_m, length_m, step_m;
};

Measures measuresFor(double longestSide_m, double stiffness_N_per_m) {
  const double length_m = std::min(kLongest_m, kLongest_of_side * longestSide_m);
  return {kStrokePress_N / stiffness_N_per_m, length_m, std::min(kStep_m, length_m / kFewestSteps)};
}

bool isFree(const CollisionMesh& surface, Vec3 place) {
  if (!surface.closed()) return true;
  int spent = 0;
  const ClosestPoint foot = surface.closestFoot(place, static_cast<int>(surface.triangleCount()) + 1, spent);
  return surface.isOutside(foot, place);
}

}  // namespace

double placesOfAStroke(double longestSide_m, double stiffness_N_per_m) noexcept {
  const auto [depth_m, length_m, step_m] = measuresFor(longestSide_m, stiffness_N_per_m);
  return std::ceil((4 * depth_m + length_m) / step_m);
}

Probes probeStrokes(const TriMesh& mesh, const CollisionMesh& surface, double stiffness_N_per_m, std::size_t count,
                    std::uint64_t seed) {
  const Vec3 size = surface.high() - surface.low();
  const auto [depth_m, length_m, step_m] = measuresFor(std::max({size.x, size.y, size.z}), stiffness_N_per_m);
  std::mt19937_64 engine(seed);
  std::vector<double> areaUpTo;
  areaUpTo.reserve(mesh.triangles.size());
  double area = 0;
  for (const TriangleIndices& t : mesh.triangles) areaUpTo.push_back(area += areaOf(mesh, t));

  std::vector<ProbeStroke> strokes;
  for (std::size_t i = 0; i < count; ++i) {
    interruptionPoint();
    const double at = area * (static_cast<double>(i) + drawn(engine)) / static_cast<double>(count);
    const double u = std::sqrt(drawn(engine)), v = drawn(engine), turn = 2 * std::numbers::pi * drawn(engine);
    const auto found = std::min(std::ranges::upper_bound(areaUpTo, at), areaUpTo.end() - 1);
    const TriangleIndices& t = mesh.triangles[static_cast<std::size_t>(found - areaUpTo.begin())];
    const Vec3 a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
    const Vec3 place = (1 - u) * a + u * (1 - v) * b + u * v * c;
    const Vec3 up = glm::normalize(glm::cross(b - a, c - a));
    const Vec3 side = glm::normalize(b - a);
    const auto [sine, cosine] = elementary::sineCosine(turn);
    const Vec3 way = length_m * (cosine * side + sine * glm::cross(up, side));
    const Vec3 rise = 2 * depth_m * up;
    const Vec3 down = place - depth_m * up;
    if (!isFree(surface, down + rise)) continue;
    ProbeStroke stroke;
    addLine(stroke, down + rise, down, step_m);
    addLine(stroke, down, down + way, step_m);
    addLine(stroke, down + way, down + way + rise, step_m);
    strokes.push_back(std::move(stroke));
  }
  std::vector<Forces> forces = forcesAlong(strokes, surface, stiffness_N_per_m);
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const auto end = std::ranges::find_if(forces[i], [](Vec3 f) { return glm::length(f) > kMaxForce_N; });
    forces[i].erase(end, forces[i].end());
    strokes[i].resize(forces[i].size());
  }
  return {std::move(strokes), std::move(forces)};
}

std::vector<Forces> forcesAlong(const std::vector<ProbeStroke>& strokes, const CollisionMesh& surface,
                                double stiffness_N_per_m) {
  Body body;
  body.surface = &surface;
  body.update();
  std::vector<Forces> all;
  for (const ProbeStroke& stroke : strokes) {
    interruptionPoint();
    Forces& forces_N = all.emplace_back();
    ContactState state;
    ContactCache cache;
    resetContact(state, stroke.front());
    for (const Vec3 hip : stroke) {
      const ContactResult contact = followContact({&body, 1}, state, hip, cache);
      forces_N.push_back(contact.touching ? stiffness_N_per_m * (contact.ihip - hip) : Vec3(0));
    }
  }
  return all;
}

}  // namespace haptics
