// Steps along the HIP's path while several surfaces hold the IHIP.

#include "haptic_server/engine/contact/active_set.h"
#include "haptic_server/engine/contact/hip_following.h"
#include "haptic_server/engine/contact/plane_solver.h"

namespace haptics {
namespace {

/// Of heldUntil(), at most: 12 for each of its two questions.
constexpr int kBisectionSteps = 24;
static_assert(kMinStep >= 0x1p-12 && kBisection == kBisectionSteps * 600);

/// Bisects for the last time at which the predicate holds.
template <class Predicate>
[[nodiscard]] double lastTime(double now, double end, Predicate holds) noexcept {
  while (end - now > kMinStep) {
    const double middle = 0.5 * (now + end);
    (holds(middle) ? now : end) = middle;
  }
  return end;
}

/// The planes of the triangles at a time. None when they leave no place.
std::optional<Constraints> constraintsAt(const TickContext& tick, const ActiveSet& held, double time) noexcept {
  Constraints constraints(tick.hipAt(time), tick.skin);
  for (const ContactSurface& s : held.surfaces()) {
    if (!constraints.add(planeOf(tick, s))) return std::nullopt;
  }
  return constraints;
}

/// Do these triangles hold at another time too? So they do where they keep the IHIP on an edge between two that both
/// rise from it.
bool staysOn(const TickContext& tick, const ActiveSet& held, double time) noexcept {
  const auto here = constraintsAt(tick, held, time);
  if (!here) return false;
  const SupportLimit limit = supportLimit(tick, held.surfaces(), *here);
  if (!limit.ends) return true;
  const auto next = across(tick, held.at[limit.surface], limit.edge);
  if (!next || !here->isCutOffBy(planeOf(tick, *next))) return false;
  const ActiveSet beyond = held.with(limit.surface, next->triangle);
  const auto there = constraintsAt(tick, beyond, time);
  if (!there) return false;
  const SupportLimit back = supportLimit(tick, beyond.surfaces(), *there);
  if (!back.ends || back.surface != limit.surface) return false;
  const auto again = across(tick, beyond.at[back.surface], back.edge);
  return again && again->triangle == held.at[limit.surface].triangle && there->isCutOffBy(planeOf(tick, *again));
}

/// Is a step of the HIP half of the longest over a triangle, or more?
bool isFast(const TickContext& tick, double step_m, const ContactSurface& s) noexcept {
  return !inOneStep(4 * step_m * step_m, squaredLength(tick.surface(s.body).triangle(s.triangle).areaNormal()));
}

}  // namespace

bool mayHaveJumped(const TickContext& tick, const Checkpoint& before, double step_m) noexcept {
  const double moved_m = glm::distance(before.ihip, tick.state.ihip) - kTouchMargin * tick.skin;
  const bool jumped =
      moved_m > kJumpRatio * step_m || (moved_m > kFastJumpRatio * step_m && isFast(tick, step_m, before.holding[0]));
  const bool letGo =
      tick.state.mode != ContactState::Mode::kSeveralSurfaces || tick.state.holdingCount < before.holdingCount;
  return jumped || (letGo && before.holdingCount > 1);  // from one surface to the next it is no farther than the HIP
}

double heldUntil(const TickContext& tick, double now, double end) noexcept {
  const ActiveSet held = heldSurfaces(tick);
  const auto allPush = [&](double time) noexcept {
    const auto constraints = constraintsAt(tick, held, time);
    return constraints && static_cast<std::size_t>(constraints->optimum.tightCount) == held.count;
  };
  const auto stays = [&](double time) noexcept { return staysOn(tick, held, time); };
  if (stays(end)) {
    if (allPush(end)) return end;
    const double push = lastTime(now, end, allPush) - kMinStep;
    if (push <= now || stays(push)) return end;
    end = push;
  }
  return lastTime(now, end, stays);
}

}  // namespace haptics
