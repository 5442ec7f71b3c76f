#include "haptic_server/contact/contact.h"

#include "haptic_server/contact/fast_path/fast_path.h"

namespace haptics {

void resetContact(ContactState& state, Vec3 hip) noexcept {
  state = {};
  state.hip = state.ihip = hip;
}

void releaseContact(ContactState& state) noexcept {
  const ContactState before = state;
  resetContact(state, before.ihip);
  state.hip = before.hip;
  state.reached = before.reached;
  state.stride = before.stride;
  state.unchecked = before.unchecked;
  state.reprojected = true;
}

ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip) noexcept {
  ContactResult result;
  followContact(bodies, state, hip, result);
  return result;
}

void followContact(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   const TriangleCache* cache) noexcept {
  (void)followFast(bodies, state, hip, result, cache);
}

}  // namespace haptics
