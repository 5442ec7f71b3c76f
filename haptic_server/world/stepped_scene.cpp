#include "haptic_server/world/stepped_scene.h"

#include <algorithm>
#include <utility>

#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/world/input_checks.h"

namespace haptics {
namespace {

constexpr double kMinRate_Hz = 100, kMaxRate_Hz = 2e4, kMaxDeviceForce_N = 1e3;

[[nodiscard]] World::Fault faultOf(Fault fault) noexcept {
  switch (fault) {
    case Fault::kNonFiniteInput:
      return World::Fault::kNonFiniteHip;
    case Fault::kNonFiniteForce:
      return World::Fault::kNonFiniteForce;
    case Fault::kDeadlinesMissed:
      return World::Fault::kMissedTicks;
    default:
      return World::Fault::kNone;
  }
}

[[nodiscard]] bool predicts(const World::Device& device) noexcept { return device.predicts && device.mass_kg > 0; }

}  // namespace

DeviceInfo infoOf(const World::Device& device) {
  check(device.rate_Hz, kMinRate_Hz, kMaxRate_Hz, " Hz", "device.rate_Hz");
  check(device.maxForce_N, 0, kMaxDeviceForce_N, " N", "device.maxForce_N");
  check(device.resolution_m, 0, 1, " m", "device.resolution_m");
  check(device.delay_s, 0, 1, " s", "device.delay_s");
  check(device.mass_kg, 0, 1e3, " kg", "device.mass_kg");
  check(device.viscousFriction_Ns_per_m, 0, 1e3, " Ns/m", "device.viscousFriction_Ns_per_m");
  check(device.coulombFriction_N, 0, 1e3, " N", "device.coulombFriction_N");
  check(device.maxStiffness_N_per_m, 0, 1e6, " N/m", "device.maxStiffness_N_per_m");
  DeviceInfo info;
  info.maxForce_N = device.maxForce_N;
  info.maxStiffness_N_per_m = device.maxStiffness_N_per_m;
  info.resolution_m = device.resolution_m;
  info.apparentMass_kg = device.mass_kg;
  info.viscousFriction_Ns_per_m = device.viscousFriction_Ns_per_m;
  info.coulombFriction_N = device.coulombFriction_N;
  info.delay_s = device.delay_s;
  return info;
}

SteppedScene::SteppedScene(const World::Device& device)
    : config_(serverStepConfig(infoOf(device), device.rate_Hz, predicts(device))),
      limits_(surfaceLimits(infoOf(device), device.rate_Hz, predicts(device))),
      state_(std::make_unique<HapticState>(config_)),
      scene_(std::make_unique<ServoScene>()) {}

void SteppedScene::publish(std::unique_ptr<ServoScene> scene) {
  next_ = std::move(scene);
  last_.reset();
}

template <class Set>
void SteppedScene::inScenes(std::uint64_t body, Set set) noexcept {
  for (ServoScene* scene : {scene_.get(), next_.get()}) {
    if (scene == nullptr) continue;
    const auto object = std::ranges::lower_bound(scene->objects, body, {}, &ServoObject::id);
    if (object != scene->objects.end() && object->id == body)
      set(*scene, static_cast<std::size_t>(object - scene->objects.begin()));
  }
}

void SteppedScene::drive(std::uint64_t body, const KinematicPose& sample) noexcept {
  inScenes(body, [&](ServoScene& scene, std::size_t object) noexcept { scene.kinematic[object] = sample; });
  beginDriving(*state_);
}

void SteppedScene::drive(std::uint64_t body, const KinematicShape& sample) noexcept {
  inScenes(body, [&](ServoScene& scene, std::size_t object) noexcept { scene.shapes[object] = sample; });
  beginReshaping(*state_);
}

World::Sample SteppedScene::step(const World::Vector& hip_m) noexcept {
  if (next_ && adoptScene(*next_, *state_, tick_)) {
    last_ = std::move(scene_);
    scene_ = std::move(next_);
  }
  StepInput input;
  input.tick = tick_++;
  input.device.position = vec(hip_m);
  input.device.state = DeviceState::kReady;
  const TelemetrySample felt = hapticStep(*scene_, *state_, config_, input);
  World::Sample sample;
  sample.force_N = vectorOf(felt.force.written);
  sample.ihip_m = vectorOf(felt.ihip);
  sample.normal = vectorOf(felt.surfaceNormal);
  sample.penetration_m = felt.penetration_m;
  sample.body = felt.object;
  sample.triangle = felt.primitive.polygon;
  sample.fault = faultOf(felt.fault);
  sample.sliding = felt.frictionState == FrictionState::kSliding;
  sample.allowanceSpent = felt.allowanceSpent != allowanceSpent_;
  allowanceSpent_ = felt.allowanceSpent;
  sample.depenetrated = felt.depenetrated != depenetrated_;
  depenetrated_ = felt.depenetrated;
  return sample;
}

void SteppedScene::run(std::span<const World::Vector> hips_m, std::span<World::Sample> samples) noexcept {
  const std::size_t count = std::min(hips_m.size(), samples.size());
  for (std::size_t i = 0; i < count; ++i) samples[i] = step(hips_m[i]);
}

}  // namespace haptics
