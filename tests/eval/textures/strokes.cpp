#include "tests/eval/textures/strokes.h"

#include <algorithm>
#include <cmath>

#include "tests/eval/spectrum.h"

namespace haptics::eval {
namespace {

constexpr int kSamples = 4096;
constexpr double kAbove_m = 2e-3;  // clear of every texture

double alongStroke(int i) { return kStroke_m * (static_cast<double>(i) / kSamples - 0.5); }

TextureSample specimenWith(const TextureCase& textureCase, const std::optional<Texture>& texture, const Feel& feel) {
  SurfaceProperties properties;
  properties.texture = texture;
  return {boardSurface(), boardDetail(properties, &textureCase), feel};
}

/// From free space straight down.
void press(TextureSample& specimen, double x_m, double depth_m) {
  specimen.place({x_m, kStrokeAcross_m, kAbove_m});
  specimen.lead({x_m, kStrokeAcross_m, -depth_m}, 50e-6);
}

/// Work on the hand along a path, by the trapezoid rule.
class Work {
 public:
  void add(const Touch& touch, Vec3 hip) {
    if (begun_) work_J_ += glm::dot((force_N_ + touch.force.contact) * 0.5, hip - hip_);
    force_N_ = touch.force.contact;
    hip_ = hip;
    begun_ = true;
  }
  [[nodiscard]] double value_J() const { return work_J_; }

 private:
  bool begun_ = false;
  Vec3 hip_{0};
  Vec3 force_N_{0};
  double work_J_ = 0;
};

}  // namespace

double ReferenceHeight::slope(double x_m) const {
  constexpr double kStep_m = 0.5e-6;
  const auto h = [&](int steps) { return at(x_m + steps * kStep_m); };
  return (8 * (h(1) - h(-1)) - (h(2) - h(-2))) / (12 * kStep_m);
}

StrokeSignals strokeOver(const TextureCase& textureCase, const Texture& texture, const Feel& feel) {
  TextureSample specimen = specimenWith(textureCase, texture, feel);
  const ReferenceHeight reference(textureCase, texture);
  StrokeSignals signals;
  press(specimen, alongStroke(0), kPressed_m);
  for (int i = 0; i < kSamples; ++i) {
    const double x_m = alongStroke(i);
    const Touch touch = specimen.tick({x_m, kStrokeAcross_m, -kPressed_m});
    signals.height_m.push_back(touch.height_m);
    signals.reference_m.push_back(reference.at(x_m));
    signals.normalForce_N.push_back(touch.force.contact.z);
    signals.lateralForce_N.push_back(touch.force.contact.x);
  }
  return signals;
}

LoopWork loopOver(const TextureCase& textureCase, const Texture& texture, const Feel& feel, bool upwards) {
  constexpr double kStep_m = 4e-6;
  const ReferenceHeight height(textureCase, texture);
  double from_m = 0;
  double to_m = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double x_m = alongStroke(i);
    if (height.at(x_m) < height.at(from_m)) from_m = x_m;
    if (height.at(x_m) > height.at(to_m)) to_m = x_m;
  }
  if (!upwards) std::swap(from_m, to_m);

  TextureSample specimen = specimenWith(textureCase, texture, feel);
  Work work;
  const auto add = [&](const Touch& touch, Vec3 hip) { work.add(touch, hip); };
  specimen.place({from_m, kStrokeAcross_m, kAbove_m});
  specimen.lead({from_m, kStrokeAcross_m, -kPressed_m}, kStep_m, add);
  specimen.lead({to_m, kStrokeAcross_m, -kPressed_m}, kStep_m, add);
  specimen.lead({to_m, kStrokeAcross_m, kAbove_m}, kStep_m, add);

  const double k = feel.stiffness_N_per_m;
  const double h1 = height.at(from_m);
  const double h2 = height.at(to_m);
  const double eq4_J = k * kPressed_m * (h2 - h1) + k * (1 - texture.gain_K) * (h2 * h2 - h1 * h1) / 2;
  return {work.value_J(), texture.law == Texture::Law::kBump ? 0 : eq4_J};
}

LateralStiffness lateralStiffnessOf(const TextureCase& textureCase, const Texture& texture, const Feel& feel) {
  constexpr int kPlaces = 400;
  constexpr double kAside_m = 2.5e-6;
  TextureSample specimen = specimenWith(textureCase, texture, feel);
  const ReferenceHeight height(textureCase, texture);
  LateralStiffness result;
  double error = 0;
  press(specimen, alongStroke(0), kPressed_m);
  const auto lateralForce = [&](double x_m) {
    return specimen.tick({x_m, kStrokeAcross_m, -kPressed_m}).force.contact.x;
  };
  for (int i = 0; i < kPlaces; ++i) {
    const double x_m = alongStroke(i * (kSamples / kPlaces));
    const double left = lateralForce(x_m - kAside_m);
    const double measured = (left - lateralForce(x_m + kAside_m)) / (2 * kAside_m);
    // The mean over the displacement, for curvature may jump: h h' has the derivative h'^2 + h h''.
    const auto lever = [&](double at_m) { return height.at(at_m) * height.slope(at_m); };
    const double derived =
        feel.stiffness_N_per_m * texture.gain_K * (lever(x_m + kAside_m) - lever(x_m - kAside_m)) / (2 * kAside_m);
    result.measuredMax_N_per_m = std::max(result.measuredMax_N_per_m, measured);
    result.derivedMax_N_per_m = std::max(result.derivedMax_N_per_m, derived);
    error = std::max(error, std::abs(measured - derived));
  }
  result.error_ratio = error / result.derivedMax_N_per_m;
  return result;
}

double falseForceAbove100Hz_N(const TextureCase& textureCase, const std::optional<Texture>& texture, const Feel& feel,
                              double encoder_m) {
  constexpr double kSpeed_m_per_s = 0.05;
  const auto ticks = static_cast<int>(kStroke_m / kSpeed_m_per_s / feel.config.period_s);
  const double k = feel.stiffness_N_per_m;
  TextureSample specimen = specimenWith(textureCase, texture, feel);
  press(specimen, alongStroke(0), kPressed_m);
  std::vector<Vec3> wrong_N;
  for (int i = 0; i < ticks; ++i) {
    const double x_m = kStroke_m * (static_cast<double>(i) / ticks - 0.5);
    const Vec3 hip{x_m, kStrokeAcross_m, -kPressed_m};
    Vec3 ideal_N{0, 0, k * kPressed_m};
    if (texture) {
      const ReferenceHeight height(textureCase, *texture);
      const double h = height.at(x_m);
      constexpr double kStep_m = 5e-6;
      const double across =
          (height.at(x_m, kStrokeAcross_m + kStep_m) - height.at(x_m, kStrokeAcross_m - kStep_m)) / (2 * kStep_m);
      ideal_N = k * Vec3(-texture->gain_K * h * height.slope(x_m), -texture->gain_K * h * across, kPressed_m + h);
    }
    const Touch touch = specimen.tick(encoder_m * glm::round(hip / encoder_m));
    wrong_N.push_back(touch.force.contact - ideal_N);
  }
  return rmsAbove(100, wrong_N, feel.config.period_s);
}

}  // namespace haptics::eval
