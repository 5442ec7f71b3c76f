// Surface properties: S13, S14, S15.

#include <algorithm>
#include <numbers>

#include "common/maths/perception.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"
#include "tests/eval/textures/closed_loop.h"

namespace haptics::eval {
namespace {

constexpr double kSoft_N_per_m = 500;

FeltSurface feltUnder(std::string_view device) {
  FeltSurface surface;
  surface.device = orThrow(findDevicePreset(device));
  return surface;
}

// ---- S13 ----

constexpr double kStroke_m_per_s = 0.05;  // a slow one, that stops
constexpr double kLetGo_m_per_s = 0.01;   // what a hand leaves behind

Rest restOnGrating(Renderer& method, double wavelength_m, double height_m, const RestCase& of) {
  const TextureCase grating = makeGrating(wavelength_m);
  FeltSurface surface = feltUnder(of.device->name);
  constexpr double kGain = 1.5;
  surface.properties.texture = textureOf(grating, height_m, kGain);
  surface.texture = grating.field;
  surface.spring_N_per_m = kRestStiffness_N_per_m;
  method.setSurfaceProperties(surface);
  Stage stage(method, Pose{});  // the device's axes are the world's
  stage.add(boardSurface());
  stage.begin({0, 0, 0.01});
  return restOn({[&](Vec3 hip) { return stage.tick(hip).force_N; }, [&](Vec3 hip) { stage.place(hip); }}, grating,
                surface.properties.texture, of);
}

// ---- S14 ----

/// `sides` strips around the y axis, each `width_m` wide; one faces z.
shapes::Shape prism(int sides, double width_m, double length_m) {
  shapes::Shape shape;
  const double radius_m = width_m / (2 * std::sin(std::numbers::pi / sides));
  const auto count = static_cast<std::uint32_t>(sides);
  for (const double y : {-length_m / 2, length_m / 2}) {
    for (int i = 0; i < sides; ++i) {
      const double turn = 2 * std::numbers::pi * (i + 0.5) / sides;
      shape.vertices.emplace_back(Vec3(radius_m * std::sin(turn), y, radius_m * std::cos(turn)));
    }
    shape.vertices.emplace_back(Vec3(0, y, 0));
  }
  const std::uint32_t other = count + 1;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    shape.triangles.push_back({i, next, other + next});
    shape.triangles.push_back({i, other + next, other + i});
    shape.triangles.push_back({count, next, i});
    shape.triangles.push_back({other + count, other + i, other + next});
  }
  return shape;
}

/// A flat top `width_m` wide along x, at z = 0, between roofs that fall by `slope_rad`, over a deep block.
shapes::Shape roof(double width_m, double slope_rad, double reach_m, double deep_m) {
  const double fall_m = reach_m * std::tan(slope_rad);
  const std::array<std::array<double, 2>, 6> section{{{-width_m / 2 - reach_m, -deep_m},
                                                      {width_m / 2 + reach_m, -deep_m},
                                                      {width_m / 2 + reach_m, -fall_m},
                                                      {width_m / 2, 0},
                                                      {-width_m / 2, 0},
                                                      {-width_m / 2 - reach_m, -fall_m}}};
  shapes::Shape shape;
  for (const double y : {-0.06, 0.06}) {
    for (const auto& [x, z] : section) shape.vertices.emplace_back(Vec3(x, y, z));
  }
  constexpr std::uint32_t kCount = 6;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::uint32_t next = (i + 1) % kCount;
    shape.triangles.push_back({i, next, kCount + next});
    shape.triangles.push_back({i, kCount + next, kCount + i});
  }
  for (std::uint32_t i = 1; i + 1 < kCount; ++i) {
    shape.triangles.push_back({0, i + 1, i});
    shape.triangles.push_back({kCount, kCount + i, kCount + i + 1});
  }
  // Seen along y, the section goes round against the clock from -y: turned, its faces look outwards.
  for (auto& t : shape.triangles) std::swap(t[1], t[2]);
  return shape;
}

constexpr double kFacet_m = 0.010;
constexpr int kSides = 12;  // vertex normals 15 degrees to either side of a facet's
constexpr double kTilt_rad = std::numbers::pi / kSides;
constexpr double kPressed_m = 0.003;
constexpr double kTickWay_m = 1e-4;

/// Largest change of the force from tick to tick on a way round at constant depth, N.
double largestStep(Stage& stage) {
  const double radius_m = kFacet_m / (2 * std::tan(kTilt_rad)) - kPressed_m;
  const auto at = [&](double turn) { return radius_m * Vec3(std::sin(turn), 0, std::cos(turn)); };
  stage.place({0, 0, radius_m + 2 * kPressed_m});
  Vec3 last(0);
  stage.lead({0, 0, radius_m + 2 * kPressed_m}, at(0), kTickWay_m,
             [&](const Felt& felt, Vec3) { last = felt.force_N; });
  double step_N = 0;
  for (double turn = kTickWay_m / radius_m; turn < 2; turn += kTickWay_m / radius_m) {
    const Vec3 force_N = stage.tick(at(turn)).force_N;
    step_N = std::max(step_N, glm::distance(force_N, last));
    last = force_N;
  }
  return step_N;
}

/// Work on the hand that presses on a facet's middle, slides `way_m` towards its edge and lifts.
double loopWork(Stage& stage, double way_m) {
  constexpr double kFine_m = 5e-6;
  const double top_m = kFacet_m / (2 * std::tan(kTilt_rad));
  const Vec3 above{0, 0, top_m + 0.001};
  const Vec3 pressed{0, 0, top_m - kPressed_m};
  const Vec3 aside{way_m, 0, 0};
  double work_J = 0;
  Vec3 lastForce_N(0);
  Vec3 lastHip = above;
  const auto add = [&](const Felt& felt, Vec3 hip) {
    work_J += glm::dot((felt.force_N + lastForce_N) * 0.5, hip - lastHip);
    lastForce_N = felt.force_N;
    lastHip = hip;
  };
  stage.place(above);
  stage.lead(above, pressed, kFine_m, add);
  stage.lead(pressed, pressed + aside, kFine_m, add);
  stage.lead(pressed + aside, above + aside, kFine_m, add);
  return work_J;
}

struct Deep {
  double step_N = 0;    ///< Largest change of the force from tick to tick on the way down.
  double tilt_deg = 0;  ///< Against the facet's normal in the end.
};
/// So deep that the depth times the tilt's tangent is beyond the facet.
Deep pressDeep(Stage& stage) {
  constexpr double kAside_m = 0.003;
  constexpr double kDeep_m = 0.060;
  Deep deep;
  Vec3 last(0);
  const Vec3 above{kAside_m, 0, 0.001};
  stage.place(above);
  stage.lead(above, {kAside_m, 0, -kDeep_m}, kTickWay_m, [&](const Felt& felt, Vec3) {
    deep.step_N = std::max(deep.step_N, glm::distance(felt.force_N, last));
    last = felt.force_N;
  });
  deep.tilt_deg = angle_deg(last, {0, 0, 1});
  return deep;
}

// ---- S15 ----

struct Slide {
  double toggles_per_s = 0;
  double step_N = 0;  ///< Largest change of the force across the floor from tick to tick.
};
/// At 5 mm/s, 2 N deep, each coordinate off by the tremor this way or that in every tick.
Slide slideTrembling(Renderer& method, Random& random, const FeltSurface& surface, double tremor_m) {
  constexpr double kSpeed_m = 5e-6;
  constexpr double kNormal_N = 2;
  constexpr int kBegin = 2000;
  constexpr int kTicks = 4000;
  method.setSurfaceProperties(surface);
  Stage stage(method, random);
  stage.add(boardSurface());
  const double depth_m = kNormal_N / surface.spring_N_per_m;
  Vec3 hip{-0.02, random.between(-0.01, 0.01), -depth_m};
  const Vec3 above{hip.x, hip.y, 0.001};
  stage.begin(above);
  stage.lead(above, hip, 50e-6, [](const Felt&, Vec3) {});
  Slide slide;
  int toggles = 0;
  bool sliding = true;
  Vec3 last(0);
  for (int i = 0; i < kBegin + kTicks; ++i) {
    hip.x += kSpeed_m;
    const Vec3 tremor = tremor_m * Vec3(random.sign(), random.sign(), 0);
    const Felt felt = stage.tick(hip + (i < kBegin ? Vec3(0) : tremor));
    if (i > kBegin) {
      toggles += felt.sliding != sliding ? 1 : 0;
      slide.step_N = std::max(slide.step_N, glm::distance(felt.force_N, last));
    }
    sliding = felt.sliding;
    last = felt.force_N;
  }
  slide.toggles_per_s = toggles / (kTicks * kPeriod_s);
  return slide;
}

}  // namespace

SceneResult restOnGratings(Renderer& method, Random& /*random*/) {
  SceneResult result;
  result.pass = true;
  double worst_um = 0;
  double worstFree_um = 0;
  int cases = 0;
  int rings = 0;
  const HandPreset light = orThrow(findHandPreset("light"));
  const HandPreset none = orThrow(findHandPreset("none"));
  for (const DevicePreset& device : devicePresets()) {
    for (const auto& [wavelength_m, height_m] : {std::pair{0.5e-3, 1e-3}, {1e-3, 1e-3}, {2e-3, 2e-3}}) {
      const Rest held =
          restOnGrating(method, wavelength_m, height_m, {&device, &light, 1 / kPeriod_s, true, kStroke_m_per_s});
      const Rest free =
          restOnGrating(method, wavelength_m, height_m, {&device, &none, 1 / kPeriod_s, true, kLetGo_m_per_s});
      worst_um = std::max(worst_um, held.cycle_um);
      worstFree_um = std::max(worstFree_um, free.cycle_um);
      rings += held.steady ? 0 : 1;
      ++cases;
    }
  }
  return {{{"cases", cases},
           {"light_hand_rings", rings},
           {"light_hand_limit_cycle_max_um", worst_um},
           {"no_hand_limit_cycle_max_um", worstFree_um}},
          rings == 0};
}

SceneResult strokeShadedFacets(Renderer& method, Random& random) {
  constexpr double kMaxStep_N = 0.05;  // five times what a cylinder's force turns by in a tick
  constexpr double kMaxDeepStep_N = 0.2;
  constexpr double kWay_m = 0.004;
  FeltSurface surface = feltUnder(kDefaultDevicePreset);
  surface.properties.shading = Shading{40 * std::numbers::pi / 180, {}};
  surface.spring_N_per_m = kSoft_N_per_m;
  method.setSurfaceProperties(surface);
  Stage facets(method, random);
  facets.add(prism(kSides, kFacet_m, 0.06));
  facets.begin({0, 0, 0.05});
  const double step_N = largestStep(facets);
  const double work_J = loopWork(facets, kWay_m);
  // The field of Eq. (1) on a facet, as printed: k d theta x / (s / 2) sideways.
  const double printed_J = kSoft_N_per_m * kPressed_m * kTilt_rad * kWay_m * kWay_m / kFacet_m;
  Stage deepStage(method, random);
  deepStage.add(roof(kFacet_m, 2 * kTilt_rad, 0.012, 0.12));
  deepStage.begin({0, 0, 0.05});
  const Deep deep = pressDeep(deepStage);
  return {{{"ticks", facets.ticks() + deepStage.ticks()},
           {"force_step_max_N", step_N},
           {"loop_work_mJ", work_J * 1e3},
           {"loop_work_as_printed_mJ", printed_J * 1e3},
           {"deep_force_step_max_N", deep.step_N},
           {"deep_tilt_deg", deep.tilt_deg}},
          step_N <= kMaxStep_N && std::abs(work_J) <= 1.05 * printed_J && deep.step_N <= kMaxDeepStep_N &&
              deep.tilt_deg <= 1};
}

SceneResult slideWithTremor(Renderer& method, Random& random) {
  constexpr double kHandTremor_m = 10e-6;
  FeltSurface surface = feltUnder(kDefaultDevicePreset);
  surface.properties.friction = Friction{0.6, 0.3, 0, {}};
  const Slide encoder = slideTrembling(method, random, surface, surface.device.resolution_m);
  const Slide hand = slideTrembling(method, random, surface, kHandTremor_m);
  return {{{"encoder_step_um", surface.device.resolution_m * 1e6},
           {"encoder_toggles_per_s", encoder.toggles_per_s},
           {"encoder_force_step_max_N", encoder.step_N},
           {"hand_tremor_um", kHandTremor_m * 1e6},
           {"hand_toggles_per_s", hand.toggles_per_s},
           {"hand_force_step_max_N", hand.step_N}},
          encoder.toggles_per_s == 0 && hand.toggles_per_s == 0};
}

}  // namespace haptics::eval
