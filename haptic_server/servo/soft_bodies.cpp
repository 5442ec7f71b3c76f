#include "haptic_server/servo/soft_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/maths/barycentric.h"
#include "haptic_server/geometry/dented_surface.h"
#include "haptic_server/servo/body_dents.h"
#include "haptic_server/surface/force_shading.h"

namespace haptics {
namespace {

/// Of a falloff's radius: a dent that has gone back this far is gone, one that is so near to what stays of it is there.
/// Larger ends with a jump; smaller keeps places.
constexpr double kGone = 0x1p-14;
/// Of a falloff's radius: what would stay shallower than this goes back. Larger loses light strokes; smaller fills the list
/// with marks that nobody sees.
constexpr double kLeastMark = 0x1p-9;
/// A dent that is so many times deeper than where its last stretch began stays at its deepest. Larger loses the end of a
/// stroke that presses harder there; smaller makes grooves uneven.
constexpr double kMuchDeeper = 1.25;
/// Where a contact finds no place for its dent, the weakest one is hurried back (seconds). Shorter can be felt; longer
/// leaves the new contact hard for longer.
constexpr double kHurried_s = 0.01;
/// Of its depth at the centre, what a dent has left where a contact comes back into it. Lower moves dents about; higher makes
/// new ones of a hand that bounces.
constexpr double kSamePlace = 0.97;
/// A dent that stays is as it is for so long before the builder may have it (seconds): a hand that comes back until then
/// goes on in the same dent. Shorter hands over more and smaller ones; longer lets a stroke run out of places.
constexpr double kStill_s = 0.2;
/// With no more places free, nothing waits for that.
constexpr std::size_t kSparePlaces = 2;

[[nodiscard]] double depthOf(const Dent& dent) noexcept { return glm::length(Vec3(dent.displacement)); }

[[nodiscard]] Dent scaled(Dent dent, double share) noexcept {
  dent.displacement *= static_cast<float>(share);
  return dent;
}

/// Goes a part of its way to what it comes to.
void comeToRest(BodyDent& dent, double left) noexcept {
  const auto share = static_cast<float>(left);
  dent.dent.displacement = dent.rest.displacement + (dent.dent.displacement - dent.rest.displacement) * share;
  if (dent.rest.displacement != Vec3f(0))
    dent.dent.centre = dent.rest.centre + (dent.dent.centre - dent.rest.centre) * share;
}

/// Puts a mark in the place before a dent, whose number it takes: a contact that moves on leaves it behind. It grows from
/// nothing, far enough from the contact not to be felt. Without a place for it there is none.
void leaveMark(HapticState& state, std::size_t at, const Dent& mark) noexcept {
  if (state.dentCount == kMaxDents) return;
  const auto from = state.dents.begin() + static_cast<std::ptrdiff_t>(at);
  std::copy_backward(from, state.dents.begin() + static_cast<std::ptrdiff_t>(state.dentCount),
                     state.dents.begin() + static_cast<std::ptrdiff_t>(state.dentCount) + 1);
  ++state.dentCount;
  if (state.pressing && state.pressedDent >= at) ++state.pressedDent;
  BodyDent& left = state.dents[at];
  left.dent = scaled(mark, 0);
  left.rest = mark;
  left.begun = {};
  left.still_s = 0;
  left.stays = false;
  state.dents[at + 1].number = ++state.dentNumber;
}

/// One contact with a soft body, in the body's frame.
class Yielding {
 public:
  /// @param object  Soft.
  Yielding(const ServoObject& object, HapticState& state, const StepConfig& config, ContactResult& contact) noexcept
      : tissue_(*object.tissue),
        shading_(object.detail ? object.detail->shading.get() : nullptr),
        state_(state),
        config_(config),
        contact_(contact),
        index_(static_cast<std::size_t>(contact.body)),
        body_(state.bodies[index_]),
        held_(state.contact.holding[0]),
        h_(body_.frame.toLocal(state.hip)) {}

  void run() noexcept {
    if (state_.pressing && isElsewhere()) state_.release();
    if (!state_.pressing && !begin()) return;
    if (state_.pressing && !press()) return;
    settle();
  }

 private:
  /// On a body with some of its dents: where it is nearest to the HIP.
  struct Nearest {
    Foot foot;
    Vec3 normal{0};
    bool outside = false;  // the HIP is
  };

  [[nodiscard]] Nearest nearest(const BodyDents& dents) noexcept {
    const DentedSurface deformed(*body_.surface, dents.all(), tissue_.falloff);
    Nearest found;
    int spent = 0;
    found.foot = deformed.closestFrom(held_.triangle, h_, spent);
    contact_.work.triangles += spent;
    found.normal = unitOrZero(deformed.normal(found.foot)) * double(held_.side);
    found.outside = glm::dot(h_ - found.foot.point, found.normal) >= 0 && contact_.penetration_m > 0;
    return found;
  }

  /// Without any, as the contact core has it.
  [[nodiscard]] Nearest nearestAtRest() const noexcept {
    Nearest found;
    found.foot.triangle = held_.triangle;
    found.foot.feature = state_.contact.feature;
    found.foot.index = contact_.primitive.localIndex;
    found.foot.point = body_.frame.toLocal(contact_.ihip);
    return found;
  }

  /// Than the dent that the contact pressed in the last tick: a fast hand has left it and come in again.
  [[nodiscard]] bool isElsewhere() const noexcept {
    const Vec3 centre(state_.dents[state_.pressedDent].dent.centre);
    const double radius = tissue_.falloff.radius_m();
    return squaredLength(body_.frame.toLocal(contact_.ihip) - centre) > radius * radius;
  }

  /// A new contact: it goes on in the body's newest dent where it comes back to that, else makes one of its own. False
  /// where the dents that there are leave the HIP outside.
  [[nodiscard]] bool begin() noexcept {
    const BodyDents dents = dentsOf(state_, index_);
    if (dents.count > 0) {
      const Nearest at = nearest(dents);
      if (at.outside) return lose();
      if (goOnInTheNewest()) return true;
    }
    if (state_.dentCount == kMaxDents) {
      hurryTheWeakest();
      return true;
    }
    state_.pressedDent = state_.dentCount++;
    state_.dents[state_.pressedDent] = {
        .body = index_, .dent = {}, .rest = {}, .begun = {}, .number = ++state_.dentNumber};
    state_.pressing = true;
    return true;
  }

  [[nodiscard]] bool goOnInTheNewest() noexcept {
    for (std::size_t i = state_.dentCount; i-- > 0;) {
      BodyDent& newest = state_.dents[i];
      if (newest.body != index_) continue;
      const BodyDents others = dentsOf(state_, index_, i);
      const Vec3 foot = (others.count > 0 ? nearest(others) : nearestAtRest()).foot.point;
      const double there = tissue_.falloff.at(foot - Vec3(newest.dent.centre));
      if (newest.stays || there < kSamePlace) return false;
      newest.dent = scaled(newest.dent, there);  // it goes along with the contact from here on
      newest.still_s = 0;
      newest.begun = newest.rest;
      state_.pressedDent = i;
      state_.pressing = true;
      return true;
    }
    return false;
  }

  /// There is no place for a dent of this contact, which is hard meanwhile.
  void hurryTheWeakest() noexcept {
    BodyDent* weakest = nullptr;
    for (BodyDent& dent : std::span(state_.dents).first(state_.dentCount)) {
      if (!dent.stays && (weakest == nullptr || depthOf(dent.dent) < depthOf(weakest->dent))) weakest = &dent;
    }
    if (weakest != nullptr) comeToRest(*weakest, std::exp(-config_.period_s / kHurried_s));
  }

  /// How far the tissue yields, over the other dents. False where those leave the HIP outside.
  [[nodiscard]] bool press() noexcept {
    const BodyDents others = dentsOf(state_, index_, state_.pressedDent);
    Nearest at = others.count > 0 ? nearest(others) : nearestAtRest();
    if (at.outside) return lose();
    if (shading_ != nullptr) shadeFoot(at.foot, others);
    const Vec3 foot = at.foot.point;
    if (tissue_.plastic > 0) moveOn(foot);
    BodyDent& pressed = state_.dents[state_.pressedDent];
    const double depth = glm::distance(h_, foot);
    const Vec3 direction = depth > 0 ? (h_ - foot) / depth : Vec3(0);
    pressed.dent.centre = Vec3f(foot);
    const double seen = seenOn(others, at.foot, pressed.dent);
    const double yielded = tissue_.yield_m(seen * depthOf(pressed.dent), depth,
                                           state_.objects[index_].felt.value().spring_N_per_m, config_.period_s);
    const double stays = std::max(stillThere_m(pressed.rest, foot), stillThere_m(pressed.begun, foot));
    const double wanted = seen > 0 ? std::max(yielded / seen, stays) : stays;
    pressed.dent.displacement = Vec3f(direction * std::clamp(wanted, 0.0, room()));
    if (tissue_.plastic > 0) remember(pressed);
    return true;
  }

  /// Where the HIP is below the smooth surface, along its normal: the dent goes that way, and not the polygon's.
  void shadeFoot(Foot& foot, const BodyDents& others) const noexcept {
    const double depth_m = glm::distance(h_, foot.point) * held_.side;
    const ShadedPoint smooth = shade(*body_.surface, *shading_, others.all(), tissue_.falloff, foot, h_, depth_m);
    if (!(smooth.weight > 0)) return;
    foot.point = glm::mix(foot.point, h_ + smooth.normal * smooth.depth_m, smooth.weight);
    foot.triangle = smooth.triangle;
  }

  /// Leaves a mark where the contact has been, each a dent's width from the last.
  void moveOn(Vec3 foot) noexcept {
    BodyDent& pressed = state_.dents[state_.pressedDent];
    const double way = glm::distance(foot, Vec3(pressed.begun.centre));
    const bool isNear = pressed.begun.displacement == Vec3f(0) || way < tissue_.falloff.width_m();
    if (isNear || state_.dentCount == kMaxDents) return;  // without a place for it, the mark is left farther on
    const Dent begun = pressed.begun;
    pressed.begun = pressed.rest = {};
    if (depthOf(begun) > kLeastMark * tissue_.falloff.radius_m()) leaveMark(state_, state_.pressedDent, begun);
  }

  /// What is to stay of a dent, at its deepest and where this stretch of its way began.
  void remember(BodyDent& pressed) const noexcept {
    const Dent kept = scaled(pressed.dent, tissue_.plastic);
    if (depthOf(kept) > depthOf(pressed.rest)) pressed.rest = kept;
    if (pressed.begun.displacement == Vec3f(0)) pressed.begun.centre = kept.centre;
    const double there = tissue_.falloff.at(Vec3(kept.centre) - Vec3(pressed.begun.centre));
    if (there * depthOf(kept) > depthOf(pressed.begun)) pressed.begun.displacement = scaled(kept, there).displacement;
  }

  [[nodiscard]] double stillThere_m(const Dent& rest, Vec3 foot) const noexcept {
    return depthOf(rest) * tissue_.falloff.at(foot - Vec3(rest.centre));
  }

  /// How deep this dent may be, so that with those of the body that are going back it stays within deepestDent_m().
  [[nodiscard]] double room() const noexcept {
    double left = deepestDent_m(tissue_.falloff);
    for (std::size_t i = 0; i < state_.dentCount; ++i) {
      const BodyDent& other = state_.dents[i];
      if (i == state_.pressedDent || other.body != index_) continue;
      left -= std::max(0.0, depthOf(other.dent) - depthOf(other.rest));
    }
    return std::max(0.0, left);
  }

  /// What there is of a dent at a foot on this mesh, which has only its vertices to show it.
  [[nodiscard]] double seenOn(const BodyDents& others, const Foot& foot, const Dent& dent) const noexcept {
    const TriangleRecord triangle = dented(body_.surface->triangle(foot.triangle), others.all(), tissue_.falloff);
    const Vec3 share = barycentric(triangle.corner(0), triangle.corner(1), triangle.corner(2), foot.point);
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += share[k] * tissue_.falloff.at(triangle.corner(k) - Vec3(dent.centre));
    return sum;
  }

  /// On the dented triangles.
  void settle() noexcept {
    const Nearest at = nearest(dentsOf(state_, index_));
    if (at.outside) {
      static_cast<void>(lose());
      return;
    }
    contact_.alongNormal = false;
    contact_.ihip = body_.frame.toWorld(at.foot.point);
    contact_.normal = body_.frame.turn(at.normal);
    contact_.penetration_m = glm::distance(contact_.ihip, state_.hip);
    contact_.primitive = primitiveOf(*body_.surface, at.foot);
    contact_.triangle = at.foot.triangle;
  }

  /// The dents leave the HIP outside.
  [[nodiscard]] bool lose() noexcept {
    const Vec3 rest = contact_.ihip;
    contact_.touching = contact_.alongNormal = false;
    contact_.body = -1;
    contact_.ihip = state_.hip;
    contact_.normal = Vec3(0);
    contact_.penetration_m = 0;
    contact_.primitive = {};
    state_.release();
    meetInDent(rest);
    return false;
  }

  /// The HIP is clear of the dent. What reaches into the dent is met there, on the way from the surface at rest.
  void meetInDent(Vec3 rest) noexcept {
    Crossing first;
    for (std::size_t i = 0; i < state_.bodyCount; ++i) {
      const Body& body = state_.bodies[i];
      if (i == index_ || body.leaving || dentsOf(state_, i).count > 0) continue;
      const Surface& s = *body.surface;
      const Crossing met = s.firstCrossing(body.frame.toLocal(rest), body.frame.toLocal(state_.hip));
      if (!met || (first && met.time >= first.time)) continue;
      first = met;
      contact_.touching = true;
      contact_.body = static_cast<int>(i);
      contact_.ihip = glm::mix(rest, state_.hip, met.time);
      contact_.normal = body.frame.turn(s.faceNormal(met.triangle) * static_cast<double>(met.side));
      contact_.penetration_m = glm::distance(contact_.ihip, state_.hip);
      contact_.primitive = primitiveOf(s, Foot{met.triangle});
      contact_.triangle = met.triangle;
    }
  }

  const SoftTissue& tissue_;
  const ShadingNormals* shading_;  // null: as the polygons are
  HapticState& state_;
  const StepConfig& config_;
  ContactResult& contact_;
  std::size_t index_;
  const Body& body_;
  HoldingSurface held_;
  Vec3 h_;
};

/// What stays of a dent that has been let go: where the last stretch of its way began, which keeps a groove even; at its
/// deepest where that is much deeper; and at both where they are a good way apart.
void letGo(HapticState& state, std::size_t at, const SoftTissue& tissue) noexcept {
  BodyDent& dent = state.dents[at];
  const double least_m = kLeastMark * tissue.falloff.radius_m();
  const Dent begun = dent.begun;
  dent.begun = {};
  const bool isApart = glm::distance(begun.centre, dent.rest.centre) > tissue.falloff.width_m() / 2;
  if (!isApart && depthOf(dent.rest) < kMuchDeeper * depthOf(begun)) dent.rest = begun;
  if (depthOf(dent.rest) <= least_m) dent.rest.displacement = Vec3f(0);
  if (isApart && depthOf(begun) > least_m) leaveMark(state, at, begun);
}

/// Dents that nothing presses go to what they come to; those that are gone leave their places.
void relax(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  const auto isPressed = [&](std::size_t i) { return state.pressing && i == state.pressedDent; };
  for (std::size_t i = 0; i < state.dentCount; ++i) {
    const BodyDent& dent = state.dents[i];
    if (!isPressed(i) && dent.begun.displacement != Vec3f(0)) letGo(state, i, *scene.objects[dent.body].tissue);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < state.dentCount; ++i) {
    BodyDent dent = state.dents[i];
    const bool pressed = isPressed(i);
    const SoftTissue& tissue = *scene.objects[dent.body].tissue;
    if (!pressed && !dent.stays) {
      comeToRest(dent, tissue.leftAfter(config.period_s));
      const double gone_m = kGone * tissue.falloff.radius_m();
      const bool isThere = glm::distance(dent.dent.displacement, dent.rest.displacement) <= gone_m;
      if (isThere && dent.rest.displacement == Vec3f(0)) continue;
      if (isThere && glm::distance(dent.dent.centre, dent.rest.centre) <= gone_m) {
        dent.dent = dent.rest;
        dent.still_s += config.period_s;
        dent.stays = dent.still_s >= kStill_s || state.dentCount + kSparePlaces >= kMaxDents;
      }
    }
    if (pressed) state.pressedDent = kept;
    state.dents[kept++] = dent;
  }
  state.dentCount = kept;
}

}  // namespace

void yieldToContact(const ServoScene& scene, HapticState& state, const StepConfig& config,
                    ContactResult& contact) noexcept {
  const SoftTissue* tissue =
      contact.touching ? scene.objects[static_cast<std::size_t>(contact.body)].tissue.get() : nullptr;
  if (tissue == nullptr ||
      (state.pressing && state.dents[state.pressedDent].body != static_cast<std::size_t>(contact.body))) {
    state.release();
  }
  const auto before = state.dents;
  const std::size_t countBefore = state.dentCount;
  relax(scene, state, config);
  if (tissue != nullptr) Yielding(scene.objects[static_cast<std::size_t>(contact.body)], state, config, contact).run();
  const auto same = [](const BodyDent& a, const BodyDent& b) { return a.body == b.body && a.dent == b.dent; };
  if (!std::ranges::equal(std::span(before).first(countBefore), state.allDents(), same)) ++state.deformationRevision;
}

bool describeDents(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept {
  bool changed = motion.dentCount != state.dentCount;
  motion.dentCount = state.dentCount;
  motion.staying = {};
  motion.sceneRevision = state.sceneRevision;
  for (std::size_t i = 0; i < state.dentCount; ++i) {
    const BodyDent& dent = state.dents[i];
    const ObjectDent now{state.objects[dent.body].id, dent.dent};
    changed = changed || !(now == motion.dent[i]);
    motion.dent[i] = now;
    if (dent.stays) motion.staying[i] = dent.number;
  }
  if (changed) motion.tick = tick;
  return changed;
}

}  // namespace haptics
