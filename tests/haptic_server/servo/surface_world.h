#pragma once

#include <memory>
#include <utility>

#include "common/mesh/generators.h"
#include "common/surface/fourier_field.h"
#include "haptic_server/surface/surface_detail.h"
#include "virtual_servo.h"

namespace haptics::testing {

/// A box of 100 mm whose upper side is the plane z = 0.
inline ServoObject slab(std::uint64_t id = 1, Vec3 at = Vec3(0, 0, -0.05)) {
  static const auto surface = surfaceOf(makeBox(Vec3(0.1), 8).value());
  return objectOf(id, surface, at, 800);
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

}  // namespace haptics::testing
