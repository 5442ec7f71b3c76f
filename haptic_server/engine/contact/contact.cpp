#include "haptic_server/engine/contact/contact.h"

#include "haptic_server/engine/contact/contact_tick.h"
#include "haptic_server/engine/contact/fast_path/clearance.h"
#include "haptic_server/engine/contact/fast_path/fast_path.h"

namespace haptics {
namespace {

using Mode = ContactState::Mode;

[[gnu::noinline]] void followNearOthers(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                        ContactResult& result, ContactCache& cache) noexcept {
  if (isUsable(hip) && followUnblocked(bodies, state, hip, result, cache)) return;
  followGuarded(bodies, state, hip, result);
}

[[gnu::noinline]] void followOnSurface(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                       ContactResult& result, ContactCache& cache) noexcept {
  if (isUsable(hip) && stayOnPolygon(bodies, state, hip, result, cache)) [[likely]]
    return;
  followNearOthers(bodies, state, hip, result, cache);
}

/// Free, or held by several surfaces.
[[gnu::noinline]] void followOffSurface(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                        ContactResult& result) noexcept {
  if (state.clear.radius_m > 0 && staysClear(bodies, state, hip)) {
    const Vec3 before = state.hip;
    state.hip = state.ihip = result.ihip = hip;
    if (isNearRim(state.clear, hip)) [[unlikely]]
      lookForClearance(bodies, state, before, result.work.allowance);
    return;
  }
  const Vec3 before = state.hip;
  const bool wasFree = state.mode == Mode::kFree;
  followGuarded(bodies, state, hip, result);
  const bool settled = !result.work.allowanceSpent && !result.work.depenetrated && !state.containmentUnchecked;
  if (wasFree && settled && state.mode == Mode::kFree) {
    lookForClearance(bodies, state, before, result.work.allowance);
  }
}

}  // namespace

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
  state.containmentUnchecked = before.containmentUnchecked;
  state.unfinished = before.unfinished;
  state.reprojected = true;
}

ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip, ContactCache& cache) noexcept {
  ContactResult result;
  followContact(bodies, state, hip, result, cache);
  return result;
}

void followContact(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   ContactCache& cache) noexcept {
  if (state.mode == Mode::kOneSurface) [[likely]]
    return followOnSurface(bodies, state, hip, result, cache);
  followOffSurface(bodies, state, hip, result);
}

}  // namespace haptics
