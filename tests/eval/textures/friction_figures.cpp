#include "tests/eval/textures/friction_figures.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/device/presets.h"
#include "tests/eval/random.h"
#include "tests/eval/spectrum.h"
#include "tests/eval/statistics.h"
#include "tests/eval/textures/texture_sample.h"

namespace haptics::eval {
namespace {

constexpr double kDepth_m = 2e-3;  // 1 N
constexpr double kStick = 0.6;
constexpr double kSlide = 0.4;
const Vec3 kWay = glm::normalize(Vec3(1, 0.31, 0));  // of a slide: along no line of the mesh

Record recordOf(const std::string& scene, Record measures, bool pass) {
  Record record{{"method", "ours"}, {"scene", scene}};
  record.update(measures);
  record["pass"] = pass;
  return record;
}

/// Felt force across the board over the felt force into it, without the friction's.
double ratioOf(const Touch& touch) {
  const double normal_N = glm::dot(touch.force.contact - touch.force.friction, touch.normal);
  return glm::length(touch.force.friction) / normal_N;
}

class Board {
 public:
  Board(const SurfaceProperties& properties, const DetailFields& fields, Random& random,
        const StepConfig& config = {.period_s = 1e-3, .maxForce_N = 1e9})
      : specimen_(boardSurface(), makeSurfaceDetail(*boardSurface(), properties, fields),
                  {500, 0, config, {random.rotation(), random.direction() * 0.05}}) {}

  /// Down to kDepth_m, the board's middle `along` metres off, y metres across the way.
  void press(double along, double across = 0) {
    across_ = across;
    specimen_.place(at(along) + Vec3(0, 0, kDepth_m + 2e-3));
    specimen_.lead(at(along), 50e-6);
  }
  /// Slides in the middle of the board, a tick each `step_m`.
  template <class Check>
  void slide(double toAlong, double step_m, Check check) {
    specimen_.lead(at(toAlong), step_m, check);
  }
  [[nodiscard]] Vec3 at(double along) const {
    return along * kWay + across_ * Vec3(-kWay.y, kWay.x, 0) - Vec3(0, 0, kDepth_m);
  }
  Touch tick(Vec3 hip) { return specimen_.tick(hip); }

 private:
  TextureSample specimen_;
  double across_ = 0;
};

SurfaceProperties frictionOf(double stick, double slide) {
  SurfaceProperties properties;
  properties.friction = Friction{stick, slide, 0, {}};
  return properties;
}

Record slideSteadily(double stick, double slide, Random& random) {
  Board board(frictionOf(stick, slide), {}, random);
  double breakAway = 0;
  double worst = 0;
  board.press(-0.03);
  board.slide(-0.02, 1e-6, [&](const Touch& t, Vec3) {  // slowly, until it gives
    if (t.friction == FrictionState::kSticking) breakAway = std::max(breakAway, ratioOf(t));
  });
  board.slide(0.03, 20e-6, [&](const Touch& t, Vec3) { worst = std::max(worst, std::abs(ratioOf(t) / slide - 1)); });
  const double breakError = std::abs(breakAway / stick - 1);
  return recordOf("friction_slide",
                  {{"mu_static_ratio", stick},
                   {"mu_dynamic_ratio", slide},
                   {"mu_dynamic_error_max_ratio", worst},
                   {"break_away_ratio", breakAway},
                   {"break_away_error_ratio", breakError}},
                  worst <= 0.005 && breakError <= 0.01);
}

/// A slide at 5 mm/s, every coordinate of every tick off by plus or minus the tremor, read by the encoder.
Record slideTrembling(const DevicePreset& device, double tremor_m, Random& random) {
  constexpr double kStep_m = 5e-6;
  StepConfig config{.period_s = 1e-3, .maxForce_N = 1e9};
  config.positionStep_m = device.resolution_m;
  Board board(frictionOf(kStick, kSlide), {}, random, config);
  board.press(-0.03);
  board.slide(-0.025, kStep_m, [](const Touch&, Vec3) {});
  constexpr int kTicks = 4000;
  int toggles = 0;
  FrictionState before = FrictionState::kSliding;
  Statistics error;
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 tremor = tremor_m * Vec3(random.sign(), random.sign(), random.sign());
    const Vec3 hip = board.at(-0.025 + kStep_m * i) + tremor;
    const Touch touch = board.tick(device.resolution_m * glm::round(hip / device.resolution_m));
    toggles += touch.friction != before ? 1 : 0;
    before = touch.friction;
    error.add(ratioOf(touch) - kSlide);
  }
  return recordOf("friction_tremor",
                  {{"device", device.name},
                   {"encoder_step_um", device.resolution_m * 1e6},
                   {"tremor_um", tremor_m * 1e6},
                   {"toggles_per_s", toggles / (kTicks * config.period_s)},
                   {"mu_error_rms_ratio", error.rms() / kSlide}},
                  toggles == 0);
}

/// Held for 10 s by a stuck contact while the encoder trembles; then turned round: it must stick again.
Record holdStill(const DevicePreset& device, Random& random) {
  StepConfig config{.period_s = 1e-3, .maxForce_N = 1e9};
  config.positionStep_m = device.resolution_m;
  Board board(frictionOf(kStick, kSlide), {}, random, config);
  board.press(0);
  const auto read = [&](double along) {
    const Vec3 tremor = device.resolution_m * Vec3(random.sign(), random.sign(), random.sign());
    return board.tick(device.resolution_m * glm::round((board.at(along) + tremor) / device.resolution_m));
  };
  constexpr double kHeld_m = 0.5e-3;  // under the 1.2 mm that break away
  for (double along = 0; along < kHeld_m; along += 10e-6) (void)read(along);
  const Vec3 start = read(kHeld_m).stickingPoint;
  double drift = 0;
  bool stuck = true;
  for (int i = 0; i < 10'000; ++i) {
    const Touch touch = read(kHeld_m);
    drift = std::max(drift, glm::distance(touch.stickingPoint, start));
    stuck = stuck && touch.friction == FrictionState::kSticking;
  }
  board.slide(0.01, 20e-6, [](const Touch&, Vec3) {});
  double back_m = 0;
  bool slides = true;
  board.slide(0.005, 5e-6, [&](const Touch& t, Vec3) {
    slides = slides && t.friction == FrictionState::kSliding;
    back_m += slides ? 5e-6 : 0;
  });
  return recordOf("friction_hold",
                  {{"device", device.name},
                   {"held_s", 10},
                   {"drift_um", drift * 1e6},
                   {"turned_round_sticks_after_um", back_m * 1e6}},
                  stuck && drift < 1e-12 && back_m < 1e-3);
}

Record slideOverPeriodicMap(Random& random) {
  constexpr double kPeriod_m = 4e-3;
  constexpr double kStep_m = 20e-6;
  SurfaceProperties properties = frictionOf(0.5, 0.5);
  const FourierFamily family{{FourierTerm{1, kWay, kPeriod_m, 0}}};
  properties.friction->variation = 0.5;
  properties.friction->over = family;
  Board board(properties, {nullptr, makeFieldOf(family), nullptr}, random);
  board.press(-0.045);
  board.slide(-0.04, kStep_m, [](const Touch&, Vec3) {});
  std::vector<double> force_N;
  double most = 0;
  double least = 1e9;
  board.slide(0.04, kStep_m, [&](const Touch& t, Vec3) {
    force_N.push_back(glm::dot(t.force.friction, kWay));
    most = std::max(most, ratioOf(t));
    least = std::min(least, ratioOf(t));
  });
  const double period_m = 0.08 / peakOf(powerSpectrum(force_N));
  const double error = std::abs(period_m / kPeriod_m - 1);
  return recordOf("friction_periodic_map",
                  {{"period_mm", kPeriod_m * 1e3},
                   {"period_recovered_mm", period_m * 1e3},
                   {"period_error_ratio", error},
                   {"mu_least_ratio", least},
                   {"mu_most_ratio", most}},
                  error <= 0.01);
}

/// Green and Salisbury's (1997) sandpaper: a grade is a mean and a variance of the coefficient.
Record slideOverSandpaper(double mean, double deviation, double grain_m, std::uint32_t seed, Random& random) {
  SurfaceProperties properties = frictionOf(mean, mean);
  const GrainFamily family{grain_m, seed};
  properties.friction->variation = deviation / mean;
  properties.friction->over = family;
  Board board(properties, {nullptr, makeFieldOf(family), nullptr}, random);
  Statistics ratio;
  double sum = 0;
  constexpr int kSlides = 60;
  for (int i = 0; i < kSlides; ++i) {
    board.press(-0.045, (i - kSlides / 2) * 1.1e-3);
    board.slide(-0.04, 50e-6, [](const Touch&, Vec3) {});
    board.slide(0.04, grain_m / 3, [&](const Touch& t, Vec3) {
      ratio.add(ratioOf(t) - mean);
      sum += ratioOf(t) - mean;
    });
  }
  const double recoveredMean = mean + sum / static_cast<double>(ratio.count());
  const double recoveredDeviation =
      std::sqrt(ratio.rms() * ratio.rms() - (recoveredMean - mean) * (recoveredMean - mean));
  const double meanError = std::abs(recoveredMean / mean - 1);
  const double deviationError = std::abs(recoveredDeviation / deviation - 1);
  return recordOf("friction_sandpaper",
                  {{"grain_mm", grain_m * 1e3},
                   {"mu_mean_ratio", mean},
                   {"mu_deviation_ratio", deviation},
                   {"mu_mean_recovered_ratio", recoveredMean},
                   {"mu_deviation_recovered_ratio", recoveredDeviation},
                   {"mean_error_ratio", meanError},
                   {"deviation_error_ratio", deviationError}},
                  meanError <= 0.05 && deviationError <= 0.05);
}

/// A factor per vertex that grows evenly along x.
Record slideOverVertices(Random& random) {
  SurfaceProperties properties = frictionOf(kSlide, kSlide);
  properties.friction->over = PerVertexScale{};
  auto scale = std::make_shared<std::vector<float>>();
  for (const Vec3f v : boardMesh().vertices) scale->push_back(1 + v.x / 0.12F);
  Board board(properties, {nullptr, nullptr, scale}, random);
  board.press(-0.045);
  board.slide(-0.04, 20e-6, [](const Touch&, Vec3) {});
  double worst = 0;
  board.slide(0.04, 20e-6, [&](const Touch& t, Vec3 hip) {
    worst = std::max(worst, std::abs(ratioOf(t) / (kSlide * (1 + hip.x / 0.12)) - 1));
  });
  return recordOf("friction_per_vertex", {{"mu_error_max_ratio", worst}}, worst <= 0.005);
}

/// The normal force that friction answers to is that of spring and texture together.
Record slideOverTexture(Random& random) {
  const TextureCase grating = makeGrating(4e-3);
  SurfaceProperties properties = frictionOf(kStick, kSlide);
  properties.texture = textureOf(grating, 0.3e-3, 1.5);
  SurfaceProperties textureAlone;
  textureAlone.texture = properties.texture;
  Board both(properties, {grating.field, nullptr, nullptr}, random);
  Board alone(textureAlone, {grating.field, nullptr, nullptr}, random);
  Statistics error;
  double textureChange = 0;
  for (Board* board : {&both, &alone}) {
    board->press(-0.045);
    board->slide(-0.04, 10e-6, [](const Touch&, Vec3) {});
  }
  std::vector<Vec3> textureForces;
  alone.slide(0.04, 10e-6, [&](const Touch& t, Vec3) { textureForces.push_back(t.force.texture); });
  std::size_t i = 0;
  both.slide(0.04, 10e-6, [&](const Touch& t, Vec3) {
    error.add(ratioOf(t) / kSlide - 1);
    textureChange = std::max(textureChange, glm::distance(t.force.texture, textureForces[i++]));
  });
  return recordOf("friction_with_texture",
                  {{"mu_dynamic_error_rms_ratio", error.rms()}, {"texture_force_change_max_N", textureChange}},
                  error.rms() <= 0.005 && textureChange < 1e-9);
}

}  // namespace

std::vector<Record> measureFriction(std::uint64_t seed) {
  Random random(seed);
  std::vector<Record> records;
  records.push_back(slideSteadily(kStick, kSlide, random));
  records.push_back(slideSteadily(1.0, 0.7, random));
  records.push_back(slideSteadily(0.2, 0.2, random));
  for (const DevicePreset& device : devicePresets()) {
    records.push_back(slideTrembling(device, device.resolution_m, random));
    records.push_back(slideTrembling(device, 10e-6, random));
    records.push_back(holdStill(device, random));
  }
  records.push_back(slideOverPeriodicMap(random));
  for (const auto& [deviation, grain_m] : {std::pair{0.05, 0.3e-3}, {0.10, 0.5e-3}, {0.15, 0.8e-3}}) {
    records.push_back(slideOverSandpaper(0.5, deviation, grain_m, static_cast<std::uint32_t>(seed), random));
  }
  records.push_back(slideOverVertices(random));
  records.push_back(slideOverTexture(random));
  return records;
}

}  // namespace haptics::eval
