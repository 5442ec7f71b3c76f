#include "tests/eval/textures/closed_loop.h"

#include <cmath>
#include <limits>

#include "common/maths/extent.h"
#include "haptic_server/device/simulated_device.h"
#include "tests/eval/random.h"
#include "tests/eval/step_config.h"

namespace haptics::eval {
namespace {

constexpr double kPress_N = 1;
const Vec3 kAbove_m(0, 0, 0.5e-3);
constexpr double kStrike_s = 2e-3;

/// Strikes sideways once, then pushes with a constant force, by its spring where it has one.
class RestingHand final : public HandIntent {
 public:
  RestingHand(Vec3 rest, Vec3 push_N, const RestCase& of) : start_{rest + kAbove_m, Vec3(0)} {
    const bool springy = of.hand->stiffness_N_per_m > 0;
    pressing_.position = springy ? rest + push_N / of.hand->stiffness_N_per_m : rest;
    pressing_.push_N = springy ? Vec3(0) : push_N;
    const double mass_kg = of.device->apparentMass_kg + of.hand->mass_kg;
    strike_N_ =
        (mass_kg * of.strike_m_per_s / kStrike_s + of.device->coulombFriction_N) * glm::normalize(Vec3(1, 0.5, 0));
  }
  HandTarget next(double dt_s, Vec3 /*felt_N*/) noexcept override {
    if (dt_s == 0) return start_;
    HandTarget now = pressing_;
    if (time_s_ < kStrike_s) now.push_N += strike_N_;
    time_s_ += dt_s;
    return now;
  }

 private:
  HandTarget start_;
  HandTarget pressing_;
  Vec3 strike_N_{0};
  double time_s_ = 0;
};

glm::dvec2 eigenvalues(const glm::dmat2& m) {
  const double mean = (m[0][0] + m[1][1]) / 2;
  const double half = std::hypot((m[0][0] - m[1][1]) / 2, m[0][1]);
  return {mean - half, mean + half};
}

struct SteepPlace {
  Vec3 place{0};
  double height_m = 0;
  double steepness = 0;  ///< Lateral stiffness over k (bump mapping) or k K.
};

/// Of many places that one which is stiffest sideways and unstable in no direction.
SteepPlace steepestOf(const TextureCase& textureCase, const Texture& texture, double depth_m) {
  constexpr int kPlaces = 4000;
  constexpr double kHalf_m = 0.02;
  Random random(1);
  SteepPlace best;
  const double a = texture.amplitude_m;
  const double zero = texture.literal ? 0 : textureCase.field->lowest();
  for (int i = 0; i < kPlaces; ++i) {
    const double x_m = random.between(-kHalf_m, kHalf_m);
    const Vec3 place{x_m, random.between(-kHalf_m, kHalf_m), 0};
    const FieldShape shape = shapeAround(*textureCase.field, place, {0, 0, 1});
    const double height_m = a * (shape.value - zero);
    const double lever = texture.law == Texture::Law::kBump ? depth_m : height_m;
    const glm::dvec2 stiffness =
        eigenvalues(a * a * glm::outerProduct(shape.slope, shape.slope) + lever * a * shape.curvature);
    const double tolerated = -1e-3 * stiffness.y;  // of waves in one direction only
    if (stiffness.x >= tolerated && stiffness.y > best.steepness) best = {place, height_m, stiffness.y};
  }
  return best;
}

}  // namespace

Vec3 forceAt(const Feeler& feeler, Vec3 rest) {
  constexpr double kClear_m = 3e-3;
  constexpr int kSettle = 400;  // ticks, for the estimate of velocity
  constexpr double kStep_m = 20e-6;
  feeler.place(Vec3(rest.x, rest.y, kClear_m));
  for (double z_m = kClear_m; z_m > rest.z; z_m -= kStep_m) (void)feeler.tick({rest.x, rest.y, z_m});
  Vec3 force_N(0);
  for (int i = 0; i < kSettle; ++i) force_N = feeler.tick(rest);
  return force_N;
}

Rest restOn(const Feeler& feeler, Vec3 rest, Vec3 push_N, const RestCase& of) {
  constexpr double kTime_s = 2;
  constexpr double kJudged_s = 0.3;
  constexpr double kRounding = 1 + 1e-6;
  RestingHand resting(rest, push_N, of);
  SimulatedDevice simulated({withoutRotation(*of.device), *of.hand, 1 / of.rate_Hz, 0}, resting);
  const auto ticks = static_cast<std::uint64_t>(kTime_s * of.rate_Hz);
  Extent extent;
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    simulated.write(feeler.tick(simulated.read(tick).position));
    if (static_cast<double>(ticks - tick) <= kJudged_s * of.rate_Hz) extent.add(simulated.plant().position());
  }
  Rest result;
  result.cycle_um = extent.longest() * 1e6;
  result.allowed_um = allowedCycle_um(*of.device);
  result.steady = result.cycle_um <= kRounding * result.allowed_um;
  result.away_mm = glm::distance(simulated.plant().position(), rest) * 1e3;
  return result;
}

Rest restOn(const Feeler& feeler, const TextureCase& textureCase, const std::optional<Texture>& texture,
            const RestCase& of) {
  const double depth_m = kPress_N / kRestStiffness_N_per_m;
  const SteepPlace steep = texture ? steepestOf(textureCase, *texture, depth_m) : SteepPlace{};
  const Vec3 rest = steep.place - Vec3(0, 0, depth_m - steep.height_m);
  const Vec3 push_N = -forceAt(feeler, rest);
  Rest result = restOn(feeler, rest, push_N, of);
  const double gain = texture && texture->law == Texture::Law::kHo1999 ? texture->gain_K : 1;
  result.stiffness_N_per_m = kRestStiffness_N_per_m * gain * steep.steepness;
  return result;
}

Rest restOn(const TextureCase& textureCase, const std::optional<Texture>& texture, const RestCase& of) {
  SurfaceProperties properties;
  properties.texture = texture;
  Feel feel;
  feel.stiffness_N_per_m = kRestStiffness_N_per_m;
  feel.config = serverConfigFor(*of.device, of.rate_Hz);
  if (!of.clamped) feel.config.stableLateral_N_per_m = std::numeric_limits<double>::infinity();
  TextureSample specimen(boardSurface(), boardDetail(properties, &textureCase), feel);
  return restOn({[&](Vec3 hip) { return specimen.tick(hip).force.written; }, [&](Vec3 hip) { specimen.place(hip); }},
                textureCase, texture, of);
}

}  // namespace haptics::eval
