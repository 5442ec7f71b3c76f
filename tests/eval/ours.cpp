#include "tests/eval/ours.h"

namespace haptics::eval {

void Ours::begin(std::span<const std::shared_ptr<const Surface>> bodies, std::span<const Pose> poses, Vec3 hip) {
  scene_ = {};
  scene_.revision = 1;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    scene_.objects.push_back({i + 1, bodies[i], poses[i], kSpring_N_per_m, 0, false});
  }
  state_ = HapticState(config_);
  tick_ = 0;
  (void)adoptScene(scene_, state_, tick_);  // nothing is in contact
  place(hip);
}

void Ours::place(Vec3 hip) {
  haptics::place(state_.contact, hip);
  state_.attached = false;
  (void)step(hip);
}

Felt Ours::tick(std::span<const Pose> poses, Vec3 hip) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    state_.bodies[i].previous = state_.bodies[i].current;
    state_.bodies[i].current = poses[i];
    state_.bodies[i].update();
  }
  return step(hip);
}

Felt Ours::step(Vec3 hip) {
  const std::span<const Body> bodies(state_.bodies.data(), state_.bodyCount);
  if (contactOnly_) {
    const ContactResult contact = followContact(bodies, state_.contact, hip);
    return {contact.touching, contact.ihip, kSpring_N_per_m * (contact.ihip - hip), 0};
  }
  // The step keeps what its contact cost to itself: asked of the same core, on a copy of its state.
  ContactState copy = state_.contact;
  const ContactWork work = followContact(bodies, copy, hip).work;
  const TelemetrySample sample = hapticStep(scene_, state_, config_, {tick_++, 0, {hip, DeviceState::kReady}});
  return {sample.object != 0, sample.ihip, sample.force.contact, work.triangles};
}

}  // namespace haptics::eval
