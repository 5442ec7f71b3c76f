#include "tests/eval/textures/traces.h"

#include <cmath>
#include <numbers>

#include "common/mesh/generators.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/textures/texture_sample.h"

namespace haptics::eval {
namespace {

constexpr double kDepth_m = 2e-3;

TextureSample boardWith(const Friction& friction, const std::shared_ptr<const ScalarField>& field) {
  SurfaceProperties properties;
  properties.friction = friction;
  TextureSample specimen(boardSurface(), makeSurfaceDetail(*boardSurface(), properties, {nullptr, field, nullptr}), {});
  specimen.place({0, 0, kDepth_m});
  specimen.lead({0, 0, -kDepth_m}, 50e-6);
  return specimen;
}

/// Through the places along x, in turn.
Trace slide(TextureSample specimen, std::initializer_list<double> turns_m, double step_m) {
  Trace trace;
  for (const double to_m : turns_m) {
    specimen.lead({to_m, 0, -kDepth_m}, step_m, [&](const Touch& t, Vec3 hip) {
      trace.emplace_back(hip.x * 1e3, -t.force.friction.x / (t.force.contact.z - t.force.friction.z));
    });
  }
  return trace;
}

Trace slideOver(const FieldFamily& family, double variation) {
  constexpr double kStep_m = 20e-6;
  constexpr double kBegun_m = 3e-3;
  const Trace all = slide(boardWith({0.5, 0.5, variation, family}, makeFieldOf(family)), {0.023}, kStep_m);
  Trace begun;
  for (const auto& [x_mm, ratio] : all) {
    if (x_mm > kBegun_m * 1e3) begun.emplace_back(x_mm - kBegun_m * 1e3, ratio);
  }
  return begun;
}

}  // namespace

FrictionTraces traceFriction(std::uint32_t seed) {
  FrictionTraces traces;
  traces.toAndFro = slide(boardWith({0.6, 0.4, 0, {}}, nullptr), {0.008, 0, 0.008}, 10e-6);
  traces.periodic = slideOver(FourierFamily{{FourierTerm{1, Vec3(1, 0, 0), 4e-3, 0}}}, 0.5);
  traces.fine = slideOver(GrainFamily{0.3e-3, seed}, 0.1);
  traces.coarse = slideOver(GrainFamily{0.8e-3, seed}, 0.3);
  return traces;
}

ShadingTraces traceShading() {
  constexpr double kRadius_m = 0.05;
  constexpr double kStep_m = 1e-4;
  constexpr int kTicks = 220;
  const TriMesh mesh = orThrow(makeSphere(kRadius_m, 12));
  const auto surface = buildCollisionMesh(mesh.vertices, mesh.triangles);
  const Quat tilt = glm::angleAxis(0.4, glm::normalize(Vec3(1, 0.5, 0.2)));
  const auto outwards = [&](double angle) { return tilt * Vec3(std::sin(angle), 0, std::cos(angle)); };
  ShadingTraces traces;
  for (const bool shaded : {false, true}) {
    SurfaceProperties properties;
    if (shaded) properties.shading = Shading{std::numbers::pi / 4, {}};
    TextureSample specimen(surface, makeSurfaceDetail(*surface, properties, {}), {});
    specimen.place(outwards(0) * (kRadius_m + kDepth_m));
    specimen.lead(outwards(0) * (kRadius_m - kDepth_m), 50e-6);
    const Vec3 across = tilt * Vec3(0, 1, 0);
    for (int i = 0; i < kTicks; ++i) {
      const double angle = kStep_m * i / kRadius_m;
      const Vec3 force = specimen.tick(outwards(angle) * (kRadius_m - kDepth_m)).force.contact;
      const Vec3 along = glm::cross(across, outwards(angle));
      const double turned = std::atan2(glm::dot(force, along), glm::dot(force, outwards(angle)));
      (shaded ? traces.shaded : traces.unshaded).emplace_back(kStep_m * i * 1e3, turned * 180 / std::numbers::pi);
    }
  }
  return traces;
}

}  // namespace haptics::eval
