#include "tests/bench/step_replay.h"

#include <numbers>
#include <utility>

#include "common/surface/fourier_field.h"
#include "common/surface/noise_field.h"

namespace haptics::bench {
namespace {

std::shared_ptr<const SurfaceDetail> detailOf(const CollisionMesh& surface, const SurfaceCase& features) {
  SurfaceProperties properties;
  DetailFields fields;
  if (features.shading) properties.shading.emplace().crease_rad = std::numbers::pi / 3;
  if (features.friction) {
    properties.friction.emplace();
    properties.friction->mu_static = 0.6;
    properties.friction->mu_dynamic = 0.4;
  }
  if (features.texture != SurfaceCase::Texture::kNone) properties.texture.emplace().amplitude_m = 1e-4;
  if (features.texture == SurfaceCase::Texture::kGrating) {
    fields.texture = std::make_shared<FourierField>(FourierFamily{{{1, Vec3(1, 0, 0), 3e-3, 0}}});
  } else if (features.texture == SurfaceCase::Texture::kNoise) {
    fields.texture = std::make_shared<NoiseField>(NoiseFamily{2e-3, 1, 0.5, 1});
  }
  return makeSurfaceDetail(surface, properties, fields);
}

StepConfig configOf(const SurfaceCase& features) {
  StepConfig config;
  if (features.stabilised) {
    config.observer = ObserverSettings{.mass_kg = 0.05,
                                       .delay_s = config.period_s,
                                       .hardBandwidth_Hz = 217,
                                       .softUpTo_N_per_m = 700,
                                       .hardFrom_N_per_m = 1600};
  }
  return config;
}

}  // namespace

StepReplay::StepReplay(Scene scene, std::uint32_t segments, const SurfaceCase& surface)
    : path_(std::move(scene)), config_(configOf(surface)), state_(std::make_unique<HapticState>(config_)) {
  scene_.revision = 1;
  scene_.objects.push_back({.id = 1,
                            .surface = sphere(segments),
                            .pose = path_.bodies.front().current,
                            .stiffness_N_per_m = 1000,
                            .damping_Ns_per_m = 0.5,
                            .detail = detailOf(*sphere(segments), surface)});
  if (surface.soft) {
    scene_.objects.back().tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.005, 2), 500, 0.1});
  }
  static_cast<void>(adoptScene(scene_, *state_, 0));  // nothing is in contact
  for (const Vec3 hip : path_.approach) static_cast<void>(hapticStep(scene_, *state_, config_, inputAt(hip)));
  for (std::size_t i = 0; i < path_.path.size(); ++i) static_cast<void>(tick());
}

}  // namespace haptics::bench
