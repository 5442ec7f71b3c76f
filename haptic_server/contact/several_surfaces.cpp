// Steps along the HIP's way while several surfaces hold the IHIP.

#include "haptic_server/contact/contact_tick.h"

namespace haptics {
namespace {

/// Bisection steps of heldUntil(), at most: 12 for each of its two questions.
constexpr int kHalvings = 24;
/// Units (Allowance) of one of them.
constexpr std::int64_t kHalving = 600;
static_assert(kMinStep >= 0x1p-12);

/// What keeps a time for as long as it is true, to a hair.
template <class Holds>
[[nodiscard]] double lastTime(double now, double end, Holds holds) noexcept {
  while (end - now > kMinStep) {
    const double middle = 0.5 * (now + end);
    (holds(middle) ? now : end) = middle;
  }
  return end;
}

}  // namespace

/// To time `end`. Where the IHIP leapt, a minimum ended on the way, and where the slide from there leads depends on where
/// the HIP was then: the step is taken back, and goes only to that time. Where a surface let go, one of those that held
/// may have ended before. Returns the time reached.
double ContactTick::advanceOnSeveral(double now, double end, const Checkpoint& before) noexcept {
  const Points from = near_.from();
  const bool interrupted = work_.interrupted, notConverged = work_.notConverged;
  const bool divisible = corrections_.substeps && before.holdingCount > 0 && work_.steps < kMaxSteps / 2 &&
                         stride_ == 1 && !hasPendingBodyMotion();
  solveAt(end);
  if (!divisible) return end;
  const double step = glm::distance(hipAt(now), hipAt(end));
  const double far = glm::distance(before.ihip, state_.ihip) - kTouchMargin * skin_;
  const bool leapt = far > kJumpRatio * step || (far > kFastJumpRatio * step && isFast(step, before.holding[0]));
  const bool letGo = state_.mode != Mode::kSeveralSurfaces || state_.holdingCount < before.holdingCount;
  if (!leapt && !letGo) return end;
  work_.allowance.spend(kHalvings * kHalving);
  if (work_.allowance.isSpent()) return end;  // a step that is not made
  const Checkpoint after = checkpoint();
  restore(before);
  const Points to = near_.from();
  near_.moveAll(from, 1);
  const double until = heldUntil(now, end);
  if (until >= end) {
    restore(after);
    near_.moveAll(to, 1);
    return end;
  }
  work_.interrupted = interrupted;
  work_.notConverged = notConverged;
  solveAt(until);
  return until;
}

/// Is a step of the HIP (m) half of the longest that there are over a triangle, or more?
bool ContactTick::isFast(double step, const ContactSurface& over) const noexcept {
  return !inOneStep(4 * step * step, squaredLength(surface(over.body).triangle(over.triangle).areaNormal()));
}

void ContactTick::solveAt(double time) noexcept {
  solve(hipAt(time));
  if (state_.mode == Mode::kOneSurface) followSurface(hipAt(time));
}

/// A hair after the time at which a triangle that holds ends under the IHIP, `end` when none does.
double ContactTick::heldUntil(double now, double end) const noexcept {
  const ActiveSet held = oneOfEachBody();
  const auto allPush = [&](double time) noexcept {
    const auto constraints = heldAt(held, time);
    return constraints && static_cast<std::size_t>(constraints->optimum.tightCount) == held.count;
  };
  const auto stays = [&](double time) noexcept { return staysOn(held, time); };
  if (stays(end)) {
    if (allPush(end)) return end;
    const double push = lastTime(now, end, allPush) - kMinStep;
    if (push <= now || stays(push)) return end;
    end = push;
  }
  return lastTime(now, end, stays);
}

/// What the triangles that hold let the IHIP come to. None when their planes leave no place.
std::optional<Constraints> ContactTick::heldAt(const ActiveSet& held, double time) const noexcept {
  Constraints constraints(hipAt(time), skin_);
  for (const ContactSurface& s : held.surfaces()) {
    if (!constraints.add(planeOf(s))) return std::nullopt;
  }
  return constraints;
}

/// Are the triangles that hold those that do at another time? So they are where they keep the IHIP on an edge between
/// two that both rise from it.
bool ContactTick::staysOn(const ActiveSet& held, double time) const noexcept {
  const auto here = heldAt(held, time);
  if (!here) return false;
  const SupportLimit limit = supportLimit(held.surfaces(), *here);
  if (!limit.ends) return true;
  const auto next = across(held.at[limit.surface], limit.edge);
  if (!next || !here->isCutOffBy(planeOf(*next))) return false;
  const ActiveSet beyond = held.with(limit.surface, next->triangle);
  const auto there = heldAt(beyond, time);
  if (!there) return false;
  const SupportLimit back = supportLimit(beyond.surfaces(), *there);
  if (!back.ends || back.surface != limit.surface) return false;
  const auto again = across(beyond.at[back.surface], back.edge);
  return again && again->triangle == held.at[limit.surface].triangle && there->isCutOffBy(planeOf(*again));
}

}  // namespace haptics
