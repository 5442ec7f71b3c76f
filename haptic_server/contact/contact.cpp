#include "haptic_server/contact/contact.h"

#include "haptic_server/contact/contact_tick_impl.h"
#include "haptic_server/contact/follow_unblocked.h"

namespace haptics {

void place(ContactState& state, Vec3 hip) noexcept {
  state = {};
  state.hip = state.ihip = hip;
}

ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip) noexcept {
  const Vec3 usable = usableHip(state, hip);
  ContactResult result;
  if (!followUnblocked(bodies, state, usable, result)) {
    result = ContactTick<AllCorrections>(bodies, state, usable).run();
  }
  return result;
}

}  // namespace haptics
