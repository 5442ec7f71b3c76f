#include "haptic_server/engine/step/relaxing_dents.h"

#include <algorithm>

namespace haptics {
namespace {

/// Fraction of a falloff's radius: a shallower dent is gone, one that is nearer to its rest has arrived.
/// Larger ends with a jump; smaller keeps places.
constexpr double kGone = 0x1p-14;
/// Of a falloff's radius: what would stay shallower than this goes back. Larger loses light strokes; smaller fills the list
/// with marks that nobody sees.
constexpr double kMinMark = 0x1p-9;
/// A dent that is so many times deeper than where its last stretch began stays at its deepest. Larger loses the end of a
/// stroke that presses harder there; smaller makes grooves uneven.
constexpr double kMuchDeeper = 1.25;
/// A dent that stays is as it is for so long before the builder may have it (seconds): a hand that comes back until then
/// goes on in the same dent. Shorter hands over more and smaller ones; longer lets a stroke run out of places.
constexpr double kDentStill_s = 0.2;
/// With no more places free, nothing waits for that.
constexpr std::size_t kSparePlaces = 2;

/// What stays of a dent that has been let go: where the last stretch of its way began, which keeps a groove even; at its
/// deepest where that is much deeper; and at both where they are a good way apart.
void letGo(HapticState& state, std::size_t at, const SoftTissue& tissue) noexcept {
  BodyDent& dent = state.dents[at];
  const Dent begun = dent.begun;
  dent.begun = {};
  const bool isApart = glm::distance(begun.centre, dent.rest.centre) > tissue.falloff.width_m() / 2;
  if (!isApart && depth_m(dent.rest) < kMuchDeeper * depth_m(begun)) dent.rest = begun;
  if (!leavesMark(dent.rest, tissue)) dent.rest.displacement = Vec3f(0);
  if (isApart && leavesMark(begun, tissue)) leaveMark(state, at, begun);
}

}  // namespace

bool leavesMark(const Dent& dent, const SoftTissue& tissue) noexcept {
  return depth_m(dent) > kMinMark * tissue.falloff.radius_m();
}

void comeToRest(BodyDent& dent, double left) noexcept {
  const auto share = static_cast<float>(left);
  dent.dent.displacement = dent.rest.displacement + (dent.dent.displacement - dent.rest.displacement) * share;
  if (dent.rest.displacement != Vec3f(0))
    dent.dent.centre = dent.rest.centre + (dent.dent.centre - dent.rest.centre) * share;
}

bool leaveMark(HapticState& state, std::size_t at, const Dent& mark) noexcept {
  if (state.dents.count == kMaxDents) return false;
  const auto from = state.dents.items.begin() + static_cast<std::ptrdiff_t>(at);
  std::copy_backward(from, state.dents.items.begin() + static_cast<std::ptrdiff_t>(state.dents.count),
                     state.dents.items.begin() + static_cast<std::ptrdiff_t>(state.dents.count) + 1);
  ++state.dents.count;
  BodyDent& left = state.dents[at];
  left.dent = scaled(mark, 0);
  left.rest = mark;
  left.begun = {};
  left.still_s = 0;
  left.pressed = left.stays = false;
  state.dents[at + 1].number = ++state.denting.newest;
  return true;
}

void relaxDents(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  for (std::size_t i = 0; i < state.dents.count; ++i) {
    const BodyDent& dent = state.dents[i];
    if (!dent.pressed && dent.begun.displacement != Vec3f(0)) letGo(state, i, *scene.objects[dent.body].tissue);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < state.dents.count; ++i) {
    BodyDent& dent = state.dents[i];
    const SoftTissue& tissue = *scene.objects[dent.body].tissue;
    if (!dent.pressed && !dent.stays) {
      comeToRest(dent, tissue.leftAfter(config.period_s));
      const double gone_m = kGone * tissue.falloff.radius_m();
      const bool isThere = glm::distance(dent.dent.displacement, dent.rest.displacement) <= gone_m;
      if (isThere && dent.rest.displacement == Vec3f(0)) continue;
      if (isThere && glm::distance(dent.dent.centre, dent.rest.centre) <= gone_m) {
        dent.dent = dent.rest;
        dent.still_s += config.period_s;
        dent.stays = dent.still_s >= kDentStill_s || state.dents.count + kSparePlaces >= kMaxDents;
      }
    }
    if (kept != i) state.dents[kept] = dent;
    ++kept;
  }
  state.dents.count = kept;
}

}  // namespace haptics
