#include "tests/eval/closed_loop_rest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/force/predictive_observer.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/stability/critical.h"
#include "tests/eval/step_config.h"
#include "tests/eval/textures/closed_loop.h"

namespace haptics::eval {
namespace {

constexpr double kRestPush_N = 1;
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

struct Spot {
  Vec3 point;   ///< On the mesh.
  Vec3 normal;  ///< Of the triangle there.
};

Spot spotAt(const Sample& sample, double way_m) {
  constexpr double kBelow_m = 1e-4;  // for the direction
  constexpr double kClear_m = 5e-3, kDeepest_m = 0.05;
  const Truth truth = sample.shape.at(way_m, kBelow_m);
  const Vec3 outwards = glm::normalize(truth.ihip - truth.hip);
  const Vec3 from = truth.ihip + outwards * kClear_m;
  const Vec3 to = truth.ihip - outwards * kDeepest_m;
  const Crossing crossing = sample.surface->firstCrossing(from, to);
  if (!crossing) throw std::logic_error("no mesh below the path of " + std::string(sample.shape.name));
  const TriangleRecord& triangle = sample.surface->triangle(crossing.triangle);
  return {glm::mix(from, to, crossing.time),
          glm::normalize(glm::cross(triangle.corner(1) - triangle.corner(0), triangle.corner(2) - triangle.corner(0)))};
}

/// The mesh with this point of it in the origin, and this direction of its frame along +z.
TestSurface groundFacing(const Sample& sample, Vec3 point, Vec3 up) {
  const Quat turn = turnOnto(up, {0, 0, 1});
  const std::string name(sample.shape.name);
  return {name, name, {sample.surface}, {{turn, -(turn * point)}}};
}

/// A method behind the stabiliser.
class StabilisedMethod final : public StabilityMethod {
 public:
  StabilisedMethod(const Method& method, const Rendering& of)
      : ground_(*of.ground),
        renderer_(method.make()),
        maxForce_N_(of.device.maxForce_N),
        stiffness_N_per_m_(of.stiffness_N_per_m),
        lead_(*serverConfigFor(of.device, 1 / of.period_s, of.delay_s).observer, of.period_s) {}

  Vec3 tick(Vec3 measured) override {
    if (!begun_) begin(measured);
    const Vec3 hip = lead_.follow(measured);
    const Felt felt = renderer_->tick(ground_.poses, hip);
    const Vec3 force_N = limitMagnitude(felt.force_N * (stiffness_N_per_m_ / kSpring_N_per_m), maxForce_N_);
    const Vec3 way = felt.ihip - hip;
    const bool pressed = felt.touching && way != Vec3(0);
    lead_.onForceWritten(force_N, pressed ? glm::normalize(way) : Vec3(0), stiffness_N_per_m_);
    return force_N;
  }

  /// Anew at a place outside, come to from farther out: some methods are larger than a point.
  void begin(Vec3 place) {
    constexpr double kFarther_m = 3e-3, kMove_m = 1e-4;
    renderer_->begin(ground_.surfaces, ground_.poses, place + Vec3(0, 0, kFarther_m));
    for (double above = kFarther_m; above > 0; above -= kMove_m) {
      (void)renderer_->tick(ground_.poses, place + Vec3(0, 0, above));
    }
    lead_.reset(place);
    begun_ = true;
  }

 private:
  const TestSurface& ground_;
  std::unique_ptr<Renderer> renderer_;
  double maxForce_N_;
  double stiffness_N_per_m_;
  PredictiveObserver lead_;
  bool begun_ = false;
};

const Vec3 kRest_m(0, 0, -kRestPush_N / kSpring_N_per_m);

Feeler feelerOf(StabilisedMethod& method) {
  return {[&](Vec3 hip) { return method.tick(hip); }, [&](Vec3 hip) { method.begin(hip); }};
}

/// The mesh turned so that the device is pressed against what the method answers there: a shaded force leans from the
/// triangle's normal, and pressed along that the device would slide away.
TestSurface groundFor(const Method& method, const Sample& sample, double way_m) {
  const Spot spot = spotAt(sample, way_m);
  TestSurface ground = groundFacing(sample, spot.point, spot.normal);
  StabilisedMethod loop(method, {&ground, device(), kPeriod_s, 0, kSpring_N_per_m});
  const Vec3 force_N = forceAt(feelerOf(loop), kRest_m);
  if (force_N == Vec3(0)) return ground;
  return groundFacing(sample, spot.point, glm::conjugate(ground.poses[0].rotation) * glm::normalize(force_N));
}

}  // namespace

ClosedLoopRest restOnMesh(const Method& method, const Sample& sample) {
  ClosedLoopRest worst{0, allowedCycle_um(device())};
  for (const double way_m : kPlaces_m) {
    const TestSurface ground = groundFor(method, sample, way_m);
    StabilisedMethod loop(method, {&ground, device(), kPeriod_s, 0, kSpring_N_per_m});
    const Feeler feeler = feelerOf(loop);
    (void)forceAt(feeler, kRest_m);
    const Rest found = restOn(feeler, kRest_m, {0, 0, -kRestPush_N}, {&device(), &nobody(), 1 / kPeriod_s});
    worst.limitCycle_um = std::max(worst.limitCycle_um, found.cycle_um);
  }
  return worst;
}

double criticalOnMesh_N_per_m(const Method& method, const Sample& sample) {
  const MethodEntry entry{method.name, method.name, method.about,
                          [&](const Rendering& of) -> std::unique_ptr<StabilityMethod> {
                            return std::make_unique<StabilisedMethod>(method, of);
                          }};
  TestSurface ground = groundFor(method, sample, kPlaces_m.front());
  StabilitySearch search{.least = kSpring_N_per_m, .most = kStiffnessSearch.most, .climb = 1.1};
  constexpr int kHeights = 3;
  for (int i = 0; i < kHeights && search.most > 0; ++i) {
    search.most = criticalStiffness_N_per_m({&entry, &ground, device(), nobody(), 1 / kPeriod_s}, search);
    const Vec3 higher(0, 0, device().resolution_m / kHeights);
    ground.poses[0].position += higher;
    ground.place += higher;
  }
  return search.most;
}

}  // namespace haptics::eval
