#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "common/mesh/generators.h"
#include "common/surface/fourier_field.h"
#include "haptic_server/engine/surface/surface_detail.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::fixture {

constexpr double kStiffness = 800;  ///< Of slab(), N/m.

/// A box of 100 mm whose upper side is the plane z = 0.
inline ServoObject slab(std::uint64_t id = 1, Vec3 at = Vec3(0, 0, -0.05)) {
  static const auto surface = surfaceOf(makeBox(Vec3(0.1), 8).value());
  return objectOf(id, surface, at, kStiffness);
}

inline std::shared_ptr<const CollisionMesh> fineBlock() {
  static const auto surface = surfaceOf(makeBox(Vec3(0.1), 60).value());
  return surface;
}

inline ServoObject with(ServoObject object, const SurfaceProperties& properties, const DetailFields& fields = {}) {
  object.detail = makeSurfaceDetail(*object.surface, properties, fields);
  return object;
}

inline SurfaceProperties friction(double stick, double slide) {
  SurfaceProperties properties;
  properties.friction.emplace();
  properties.friction->mu_static = stick;
  properties.friction->mu_dynamic = slide;
  return properties;
}

inline SurfaceProperties shading(double crease_rad) {
  SurfaceProperties properties;
  properties.shading.emplace().crease_rad = crease_rad;
  return properties;
}

/// A grating across x, f from -1 to 1.
inline std::shared_ptr<const ScalarField> gratingField(double wavelength_m) {
  return std::make_shared<FourierField>(FourierFamily{{{1, Vec3(1, 0, 0), wavelength_m, 0}}});
}

/// Of height 0 to twice the amplitude.
inline ServoObject withGrating(ServoObject object, double wavelength_m, double amplitude_m, double gain = 1.5,
                               SurfaceProperties properties = {}, bool literal = false) {
  properties.texture =
      Texture{.family = FourierFamily{}, .amplitude_m = amplitude_m, .literal = literal, .gain_K = gain};
  return with(std::move(object), properties, {gratingField(wavelength_m), nullptr, nullptr});
}

/// Of height 0 to 1 mm across z: as high all over the upper side of a box of 0.1 m, about the middle of which z is 0 or 0.05 m.
inline constexpr double kHeight_m = 0.001;
inline Texture acrossDepth() { return {.family = FourierFamily{}, .amplitude_m = kHeight_m / 2}; }
inline std::shared_ptr<const ScalarField> depthField() {
  return std::make_shared<FourierField>(FourierFamily{{{1, Vec3(0, 0, 1), 0.005, 0}}});
}

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 1e9};

/// Down to `depth_m` on the slab at x = -40 mm within 200 ticks, then along x.
inline VirtualServo::Trajectory strokeAlongX(double depth_m, double speed_m_per_s) {
  return [=](std::uint64_t tick) {
    const double down = std::min(1.0, static_cast<double>(tick) / 200);
    const double along = tick > 300 ? 1e-3 * speed_m_per_s * static_cast<double>(tick - 300) : 0;
    return Vec3(-0.04 + along, 0.0123, 0.003 - (0.003 + depth_m) * down);
  };
}

/// 2 mm deep into the slab, then half a millimetre along x.
inline Vec3 pressThenAside(std::uint64_t tick) {
  return {tick > 300 ? 0.0005 : 0, 0.0123, std::max(-0.002, 0.003 - 5e-5 * static_cast<double>(tick))};
}

/// Over the top of a sphere of 50 mm, 2 mm deep.
inline Vec3 overSphere(std::uint64_t tick) {
  const double down = std::min(1.0, static_cast<double>(tick) / 200);
  const double angle = tick > 300 ? 1e-4 * static_cast<double>(tick - 300) / 0.05 : 0;
  return (0.052 - 0.004 * down) * glm::normalize(Vec3(std::sin(angle), 0.2, std::cos(angle)));
}

/// Down to 3 mm deep in a sphere of 50 mm, and about its middle from tick 400 on.
inline Vec3 aboutSphere(std::uint64_t tick) {
  const double down = std::min(1.0, static_cast<double>(tick) / 300);
  const double angle = tick > 400 ? 5e-4 * static_cast<double>(tick - 400) : 0;
  return (0.051 - 0.004 * down) * glm::normalize(Vec3(std::sin(0.2 + angle), 0.2 + 0.1 * angle, std::cos(0.2 + angle)));
}

}  // namespace haptics::fixture
