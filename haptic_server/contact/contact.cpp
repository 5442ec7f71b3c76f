#include "haptic_server/contact/contact.h"

#include "haptic_server/contact/fast_path/fast_path.h"

namespace haptics {

void place(ContactState& state, Vec3 hip) noexcept {
  state = {};
  state.hip = state.ihip = hip;
}

void unseat(ContactState& state) noexcept {
  const ContactState before = state;
  place(state, before.ihip);
  state.hip = before.hip;
  state.reached = before.reached;
  state.stride = before.stride;
  state.unchecked = before.unchecked;
  state.reseated = true;
}

ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip) noexcept {
  ContactResult result;
  followContact(bodies, state, hip, result);
  return result;
}

void followContact(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   const KnownPolygons* known) noexcept {
  (void)followFast(bodies, state, hip, result, known);
}

}  // namespace haptics
