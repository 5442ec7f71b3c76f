#include "haptic_server/servo/pre_touch.h"

#include "haptic_server/contact/neighborhood_watch.h"

namespace haptics {
namespace {

/// Asks for the polygons two rings around the contact, and searches back to it from the first ring, as a tick that
/// crosses a line would.
void lookAround(const Surface& surface, std::uint32_t triangle, Vec3 ihip) noexcept {
  const TriangleRecord& own = surface.triangle(triangle);
  for (int k = 0; k < 3; ++k) {
    if (own.neighbour(k) != kNoTriangle) surface.prefetch(own.neighbour(k));
  }
  for (int k = 0; k < 3; ++k) {
    if (own.neighbour(k) == kNoTriangle) continue;
    const TriangleRecord& next = surface.triangle(own.neighbour(k));
    for (int j = 0; j < 3; ++j) {
      if (next.neighbour(j) != kNoTriangle) surface.prefetch(next.neighbour(j));
    }
    int spent = 0;
    static_cast<void>(neighborhoodWatch(surface, own.neighbour(k), ihip, nullptr, spent));
  }
}

}  // namespace

void PreTouch::operator()(const ServoScene& scene, const HapticState& state) noexcept {
  if (!state.attached) return;
  rehearse(scene, state);
  const ContactState& contact = rehearsal_.contact;
  for (const HoldingSurface& held : contact.surfaces()) {
    const Body& body = rehearsal_.bodies[static_cast<std::size_t>(held.body)];
    lookAround(*body.surface, held.triangle, body.frame.toLocal(contact.ihip));
  }
  rehearse(scene, state);
}

void PreTouch::rehearse(const ServoScene& scene, const HapticState& state) noexcept {
  rehearsal_.copyInUse(state);
  const Vec3 next = state.measuredHip + state.velocity.velocity() * config_.period_s;
  FeltTick felt;
  feelForce(scene, rehearsal_, config_, {0, 0, {next, DeviceState::kReady}}, felt);
}

}  // namespace haptics
