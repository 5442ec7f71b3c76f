#include "tests/eval/closed_loop_rest.h"

#include <array>
#include <memory>
#include <stdexcept>
#include <string>

#include "haptic_server/force/lead_observer.h"
#include "haptic_server/force/output_chain.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/stability/critical.h"
#include "tests/eval/step_config.h"
#include "tests/eval/textures/closed_loop.h"

namespace haptics::eval {
namespace {

constexpr double kPush_N = 1;
/// On every shape's path the surface is there, and no edge of the true one is near.
constexpr std::array kPlaces_m{0.005, 0.02, 0.035, 0.05};

const DevicePreset& device() {
  static const DevicePreset preset = orThrow(findDevicePreset(kDefaultDevicePreset));
  return preset;
}
const HandPreset& nobody() {
  static const HandPreset preset = orThrow(findHandPreset("none"));
  return preset;
}

Quat turnOnto(Vec3 from, Vec3 to) {
  const Vec3 axis = glm::cross(from, to);
  const double sine = glm::length(axis);
  const double cosine = glm::dot(from, to);
  if (sine == 0) return cosine > 0 ? Quat(1, 0, 0, 0) : glm::angleAxis(std::numbers::pi, Vec3(1, 0, 0));
  return glm::angleAxis(std::atan2(sine, cosine), axis / sine);
}

/// The mesh with the place of it that the path passes in the origin, and the triangle there facing +z.
Ground groundAt(const Sample& sample, double way_m) {
  constexpr double kBelow_m = 1e-4;  // for the direction
  constexpr double kClear_m = 5e-3, kDeepest_m = 0.05;
  const Truth truth = sample.shape.at(way_m, kBelow_m);
  const Vec3 outwards = glm::normalize(truth.ihip - truth.hip);
  const Vec3 from = truth.ihip + outwards * kClear_m;
  const Vec3 to = truth.ihip - outwards * kDeepest_m;
  const Crossing crossing = sample.surface->firstCrossing(from, to);
  if (!crossing) throw std::logic_error("no mesh below the path of " + std::string(sample.shape.name));
  const TriangleRecord& triangle = sample.surface->triangle(crossing.triangle);
  const Vec3 normal =
      glm::normalize(glm::cross(triangle.corner(1) - triangle.corner(0), triangle.corner(2) - triangle.corner(0)));
  const Quat turn = turnOnto(normal, {0, 0, 1});
  const std::string name(sample.shape.name);
  return {name, name, {sample.surface}, {{turn, -(turn * glm::mix(from, to, crossing.time))}}};
}

/// A method behind the stabiliser.
class StabilisedMethod final : public StabilityMethod {
 public:
  StabilisedMethod(const Method& method, const Rendering& of)
      : ground_(*of.ground),
        renderer_(method.make()),
        maxForce_N_(of.device.maxForce_N),
        stiffness_N_per_m_(of.stiffness_N_per_m),
        lead_(*serverConfigFor(of.device, 1 / of.period_s, of.delay_s).lead, of.period_s) {}

  Vec3 tick(Vec3 measured) override {
    if (!begun_) begin(measured);
    const Vec3 hip = lead_.follow(measured);
    const Felt felt = renderer_->tick(ground_.poses, hip);
    const Vec3 force_N = limitMagnitude(felt.force_N * (stiffness_N_per_m_ / kSpring_N_per_m), maxForce_N_);
    const Vec3 way = felt.ihip - hip;
    const bool pressed = felt.touching && way != Vec3(0);
    lead_.note(force_N, pressed ? glm::normalize(way) : Vec3(0), stiffness_N_per_m_);
    return force_N;
  }

  /// Anew at a place outside, come to from farther out: some methods are larger than a point.
  void begin(Vec3 place) {
    constexpr double kFarther_m = 3e-3, kStep_m = 1e-4;
    renderer_->begin(ground_.surfaces, ground_.poses, place + Vec3(0, 0, kFarther_m));
    for (double above = kFarther_m; above > 0; above -= kStep_m) {
      (void)renderer_->tick(ground_.poses, place + Vec3(0, 0, above));
    }
    lead_.reset(place);
    begun_ = true;
  }

 private:
  const Ground& ground_;
  std::unique_ptr<Renderer> renderer_;
  double maxForce_N_;
  double stiffness_N_per_m_;
  LeadObserver lead_;
  bool begun_ = false;
};

}  // namespace

ClosedLoopRest restOnMesh(const Method& method, const Sample& sample) {
  ClosedLoopRest worst{0, allowedCycle_um(device())};
  for (const double way_m : kPlaces_m) {
    const Ground ground = groundAt(sample, way_m);
    StabilisedMethod loop(method, {&ground, device(), kPeriod_s, 0, kSpring_N_per_m});
    const Feeler feeler{[&](Vec3 hip) { return loop.tick(hip); }, [&](Vec3 hip) { loop.begin(hip); }};
    const Vec3 rest(0, 0, -kPush_N / kSpring_N_per_m);
    (void)forceAt(feeler, rest);
    const Rest found = restOn(feeler, rest, {0, 0, -kPush_N}, {&device(), &nobody(), 1 / kPeriod_s});
    worst.limitCycle_um = std::max(worst.limitCycle_um, found.cycle_um);
  }
  return worst;
}

double criticalOnMesh_N_per_m(const Method& method, const Sample& sample) {
  const MethodEntry entry{method.name, method.name, method.about,
                          [&](const Rendering& of) -> std::unique_ptr<StabilityMethod> {
                            return std::make_unique<StabilisedMethod>(method, of);
                          }};
  const Ground ground = groundAt(sample, kPlaces_m.front());
  return criticalStiffness_N_per_m({&entry, &ground, device(), nobody(), 1 / kPeriod_s});
}

}  // namespace haptics::eval
