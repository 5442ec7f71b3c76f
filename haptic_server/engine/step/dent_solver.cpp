#include "haptic_server/engine/step/dent_solver.h"

#include <algorithm>
#include <span>

#include "common/maths/barycentric.h"
#include "common/maths/elementary.h"
#include "haptic_server/engine/step/relaxing_dents.h"
#include "haptic_server/engine/surface/force_shading.h"

namespace haptics {
namespace {

/// Where a contact finds no place for its dent, the weakest one is hurried back (seconds). Shorter can be felt; longer
/// leaves the new contact hard for longer.
constexpr double kHurried_s = 0.01;
/// Of its depth at the centre, what a dent has left where a contact comes back into it. Lower moves dents about; higher
/// makes new ones of a hand that bounces.
constexpr double kSamePlace = 0.97;

/// Units (Allowance) of the closest point of a triangle with as many dents.
[[nodiscard]] std::int64_t unitsOfTriangle(std::size_t dents) noexcept {
  constexpr std::int64_t kDent = 10;
  return Allowance::kNearTriangle + kDent * static_cast<std::int64_t>(dents);
}

/// Triangles that a search may look at: a quarter of what is left of the allowance, for there are several of them in a tick,
/// and a few where nothing is.
[[nodiscard]] int affordable(const Allowance& allowance, std::int64_t unitsOfEach) noexcept {
  constexpr std::int64_t kMin = 4;
  return static_cast<int>(std::clamp<std::int64_t>(allowance.left() / (4 * unitsOfEach), kMin, DentedSurface::kBudget));
}

}  // namespace

DentSolver::DentSolver(const ServoScene& scene, HapticState& state, const StepConfig& config, ContactWork& work,
                       const PressedBody& pressed) noexcept
    : tissue_(*scene.objects[pressed.body].tissue),
      shading_(pressed.alone && scene.objects[pressed.body].detail ? scene.objects[pressed.body].detail->shading.get()
                                                                   : nullptr),
      state_(state),
      config_(config),
      work_(work),
      pressed_(pressed),
      body_(state.bodies[pressed.body]) {
  for (std::size_t i = 0; i < state.dents.count; ++i) {
    if (state.dents[i].pressed && state.dents[i].body == pressed.body) at_ = i;
  }
}

bool DentSolver::press() noexcept {
  ClosestPoint foot = pressed_.atRest;
  if (at_) {
    const BodyDents others = dentsOf(state_, pressed_.body, *at_);
    if (!findFoot(others, foot)) return false;
    if (!isElsewhere(foot)) {
      yield(others, foot);
      return true;
    }
    dent().pressed = false;
    at_.reset();
  }
  if (!begin()) return false;
  if (!at_) return true;
  const BodyDents others = dentsOf(state_, pressed_.body, *at_);
  if (!findFoot(others, foot)) return false;
  yield(others, foot);
  return true;
}

DentSolver::Nearest DentSolver::nearestTo(const Vec3& point) noexcept {
  return nearest(dentsOf(state_, pressed_.body), point);
}

DentSolver::Nearest DentSolver::nearest(const BodyDents& dents, const Vec3& point) noexcept {
  DentedSurface deformed(*body_.surface, dents.all(), tissue_.falloff);
  Nearest found;
  int spent = 0;
  const std::int64_t unitsOfEach = unitsOfTriangle(dents.count);
  const int most = affordable(work_.allowance, unitsOfEach);
  found.foot = deformed.closestFrom(pressed_.atRest.triangle, point, spent, most);
  if (spent == most && most < DentedSurface::kBudget) state_.fallBehind(work_);
  work_.triangles += spent;
  work_.allowance.spend(unitsOfEach * spent);
  found.normal = unitOrZero(deformed.normal(found.foot)) * double(pressed_.side);
  found.outside = glm::dot(point - found.foot.point, found.normal) >= 0 && pressed_.below;
  return found;
}

/// Where the dent goes down from: the place nearest to the HIP on the surface with the other dents. False where those leave
/// the HIP outside.
bool DentSolver::findFoot(const BodyDents& others, ClosestPoint& foot) noexcept {
  if (others.count == 0 && pressed_.alone) return true;
  const Nearest found = nearest(others, pressed_.h);
  foot = found.foot;
  return !found.outside;
}

/// Is the contact elsewhere than the dent pressed in the last tick? A fast hand has left it and come in again.
bool DentSolver::isElsewhere(const ClosestPoint& foot) const noexcept {
  const double radius = tissue_.falloff.radius_m();
  return squaredLength(foot.point - Vec3(dent().dent.centre)) > radius * radius;
}

/// A new contact: it goes on in the body's newest dent where it comes back to that, else makes one of its own, if there is
/// a place for it. False where the dents that there are leave the HIP outside.
bool DentSolver::begin() noexcept {
  const BodyDents dents = dentsOf(state_, pressed_.body);
  if (dents.count > 0) {
    if (nearest(dents, pressed_.h).outside) return false;
    if (continueNewestDent()) return true;
  }
  if (state_.dents.count == kMaxDents) {
    evictWeakestDent();
    return true;
  }
  at_ = state_.dents.count++;
  dent() = {
      .body = pressed_.body, .dent = {}, .rest = {}, .begun = {}, .number = ++state_.denting.newest, .pressed = true};
  return true;
}

bool DentSolver::continueNewestDent() noexcept {
  for (std::size_t i = state_.dents.count; i-- > 0;) {
    BodyDent& newest = state_.dents[i];
    if (newest.body != pressed_.body) continue;
    const BodyDents others = dentsOf(state_, pressed_.body, i);
    const Vec3 foot = (others.count > 0 ? nearest(others, pressed_.h).foot : pressed_.atRest).point;
    const double there = tissue_.falloff.at(foot - Vec3(newest.dent.centre));
    if (newest.stays || there < kSamePlace) return false;
    newest.dent = scaled(newest.dent, there);  // it goes along with the contact from here on
    newest.still_s = 0;
    newest.begun = newest.rest;
    newest.kept_m = there * depth_m(newest.rest);
    newest.pressed = true;
    at_ = i;
    return true;
  }
  return false;
}

/// There is no place for a dent of this contact, which is hard meanwhile.
void DentSolver::evictWeakestDent() noexcept {
  BodyDent* weakest = nullptr;
  for (BodyDent& dent : state_.dents.all()) {
    if (dent.stays || dent.pressed) continue;
    if (weakest == nullptr || depth_m(dent.dent) < depth_m(weakest->dent)) weakest = &dent;
  }
  if (weakest != nullptr) comeToRest(*weakest, elementary::exp(-config_.period_s / kHurried_s));
}

/// How far the tissue yields, over the other dents.
void DentSolver::yield(const BodyDents& others, ClosestPoint at) noexcept {
  Vec3 parts(0);  // of the smooth foot
  if (shading_ != nullptr) shadeFoot(at, others, parts);
  if (isPlastic()) moveOn(at.point);
  BodyDent& pressedDent = dent();
  const double depth = glm::distance(pressed_.h, at.point);
  const Vec3 direction = depth > 0 ? (pressed_.h - at.point) * (1 / depth) : Vec3(0);
  pressedDent.dent.centre = Vec3f(at.point);
  const bool isSmooth = smooth_.weight == 1 && others.count == 0;
  const double seen = isSmooth ? seenOn(body_.surface->triangle(at.triangle), parts, pressedDent.dent)
                               : seenOn(others, at, pressedDent.dent);
  const double yielded = tissue_.yield_m(seen * depth_m(pressedDent.dent), depth, pressed_.contact_N_per_m,
                                         config_.period_s, pressed_.softness);
  const auto remaining_m = [&](const Dent& mark) noexcept {
    return mark.displacement == Vec3f(0) ? 0 : depth_m(mark) * tissue_.falloff.at(at.point - Vec3(mark.centre));
  };
  const double stays = std::max(remaining_m(pressedDent.rest), remaining_m(pressedDent.begun));
  const double wanted = seen > 0 ? std::max(yielded / seen, stays) : stays;
  const double now_m = std::clamp(wanted, 0.0, room_m());
  pressedDent.dent.displacement = Vec3f(direction * now_m);
  if (wanted <= stays) pressedDent.kept_m = stays;
  const double kept_m = std::min(pressedDent.kept_m, stays);
  smooth_.depth_m -= seen * now_m * pressed_.side;
  elastic_m2_ = seen * seen * std::max(0.0, now_m * now_m - kept_m * kept_m);
  if (isPlastic()) remember(pressedDent);
}

/// Where the HIP is below the smooth surface, along its normal: the dent goes that way, and not the polygon's.
void DentSolver::shadeFoot(ClosestPoint& foot, const BodyDents& others, Vec3& parts) noexcept {
  const double depth = glm::distance(pressed_.h, foot.point) * pressed_.side;
  smooth_ = shade(*body_.surface, *shading_, others.all(), tissue_.falloff, foot, pressed_.h, depth, &parts);
  if (!(smooth_.weight > 0)) return;
  foot.point = glm::mix(foot.point, pressed_.h + smooth_.normal * smooth_.depth_m, smooth_.weight);
  foot.triangle = smooth_.triangle;
}

/// Leaves a mark where the contact has been, each a dent's width from the last.
void DentSolver::moveOn(Vec3 foot) noexcept {
  const double way = glm::distance(foot, Vec3(dent().begun.centre));
  const bool isNear = dent().begun.displacement == Vec3f(0) || way < tissue_.falloff.width_m();
  if (isNear || state_.dents.count == kMaxDents) return;  // without a place for it, the mark is left farther on
  const Dent begun = dent().begun;
  dent().begun = dent().rest = {};
  dent().kept_m = 0;
  if (leavesMark(begun, tissue_) && leaveMark(state_, *at_, begun)) ++*at_;
}

/// What is to stay of a dent, at its deepest and where this stretch of its way began.
void DentSolver::remember(BodyDent& pressed) const noexcept {
  const Dent kept = scaled(pressed.dent, tissue_.plastic);
  if (depth_m(kept) > depth_m(pressed.rest)) pressed.rest = kept;
  if (pressed.begun.displacement == Vec3f(0)) pressed.begun.centre = kept.centre;
  const double there = tissue_.falloff.at(Vec3(kept.centre) - Vec3(pressed.begun.centre));
  if (there * depth_m(kept) > depth_m(pressed.begun)) pressed.begun.displacement = scaled(kept, there).displacement;
}

/// How deep this dent may be, so that with those of the body that are going back it stays within maxDentDepth_m(). It may be
/// as deep as it is: where one that stayed is released beside it, it waits until that has gone back.
double DentSolver::room_m() const noexcept {
  double left = maxDentDepth_m(tissue_.falloff);
  for (std::size_t i = 0; i < state_.dents.count; ++i) {
    const BodyDent& other = state_.dents[i];
    if (i == *at_ || other.body != pressed_.body) continue;
    left -= std::max(0.0, depth_m(other.dent) - depth_m(other.rest));
  }
  return std::max(depth_m(dent().dent), left);
}

/// What there is of a dent at a foot on this mesh, which has only its vertices to show it.
double DentSolver::seenOn(const BodyDents& others, const ClosestPoint& foot, const Dent& dent) const noexcept {
  const auto on = [&](const TriangleRecord& t) noexcept {
    return seenOn(t, barycentric(t.corner(0), t.corner(1), t.corner(2), foot.point), dent);
  };
  const TriangleRecord& atRest = body_.surface->triangle(foot.triangle);
  return others.count > 0 ? on(dented(atRest, others.all(), tissue_.falloff)) : on(atRest);
}

double DentSolver::seenOn(const TriangleRecord& triangle, const Vec3& parts, const Dent& dent) const noexcept {
  const Double4 there = partsOf(dent, cornersAtOnce(triangle), tissue_.falloff);
  return parts[0] * there[0] + parts[1] * there[1] + parts[2] * there[2];
}

}  // namespace haptics
