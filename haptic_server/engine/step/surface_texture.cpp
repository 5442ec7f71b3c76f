#include <algorithm>
#include <cmath>
#include <optional>

#include "haptic_server/engine/step/dent_solver.h"
#include "haptic_server/engine/step/material_map.h"
#include "haptic_server/engine/step/separation_speed.h"
#include "haptic_server/engine/step/surface_forces.h"
#include "haptic_server/engine/step/surface_stages.h"
#include "haptic_server/engine/surface/nearest_point.h"

namespace haptics {
namespace {

/// Units (Allowance) of a texture's field: a sum of 64 waves.
constexpr std::int64_t kField = 600;
/// Of a surface's size, how much farther than its highest bump reaches its nearest point is looked for. Larger looks
/// less often and farther each time.
constexpr double kLookAhead = 0.02;
/// Way of a hand that leaves a surface, in a tick. Larger lets a larger step of adhesion through.
constexpr double kUsualWay_m = 1e-4;

/// After an edit: the part of the new height that is what was felt of the old one. Of a lower one it would be more than
/// all, that is a steeper texture than anybody asked for: that step is EditSlew's.
void rescaleAfterEdit(BumpState& bump, double height_m) noexcept {
  const double part = bump.height_m / height_m;
  bump.blendWeight = std::isfinite(part) ? std::clamp(part, 0.0, 1.0) : 0;
}

/// All of it in the middle half of its reach, and linear to 0 on both sides: without a step there, nor where its direction
/// turns around a line of the surface. Less where that would be stiffer than a device bears.
[[nodiscard]] double adhesionAt(double distance_m, double asked_N, double most_N_per_m) noexcept {
  constexpr double kRamp_m = kAdhesionReach_m / 4;
  const double part = std::min(distance_m, kAdhesionReach_m - distance_m) / kRamp_m;
  return std::min(asked_N, most_N_per_m * kRamp_m) * std::clamp(part, 0.0, 1.0);
}

/// Is a point another one than that of the triangle which was the nearest, by more than the HIP has moved?
[[nodiscard]] bool jumps(const ClosestPoint& foot, const CollisionMesh& surface, std::uint32_t last, const Vec3& h,
                         double moved_m) noexcept {
  constexpr double kRounding_m = 1e-5;
  return last == kNoTriangle ||
         glm::distance(foot.point, closestOn(surface.triangle(last), last, h).point) > 2 * moved_m + kRounding_m;
}

/// The surface of the body that holds the IHIP: of several always the same one, whatever order they are in.
[[nodiscard]] std::optional<std::size_t> heldSurfaceOf(const ContactState& contact, std::size_t body) noexcept {
  const auto holding = contact.surfaces();
  std::optional<std::size_t> held;
  for (std::size_t k = 0; k < holding.size(); ++k) {
    if (static_cast<std::size_t>(holding[k].body) != body) continue;
    if (!held || holding[k].triangle < holding[*held].triangle) held = k;
  }
  return held;
}

}  // namespace

void SurfaceForceModel::computeBumpForces() noexcept {
  const bool heldTogether = contact_.touching && severalBodiesHold(state_);
  for (std::size_t i = 0; i < state_.objects.count && count_ < kMaxTouches; ++i) {
    if (detail(i) == nullptr || !(detail(i)->reach_m > 0) || state_.bodies[i].pendingRemoval) continue;
    if (isTouched(i) && !heldTogether) continue;
    if (contact_.work.allowance.isSpent()) return state_.fallBehind(contact_.work);
    SurfaceContact touch{};
    touch.body = i;
    const auto held = heldTogether ? heldSurfaceOf(state_.contact, i) : std::nullopt;
    if (!(held ? takeHeldSurface(touch, *held) : findNearestPoint(touch))) continue;
    if (state_.features.varyingStiffness && !touch.heightOnly) varyBeside(touch);
    addTextureHeight(touch, state_.bumps[i]);
    if (!(touch.depth_m > 0)) continue;
    // Where the polygons are touched next, shading goes on.
    if (count_ == 0 && !touch.inHollow)
      memory_.fade = {.mode = touch.shaded ? ShadingFade::Mode::kAlone : ShadingFade::Mode::kOff};
    touches_[count_++] = touch;
  }
}

bool SurfaceForceModel::takeHeldSurface(SurfaceContact& touch, std::size_t held) noexcept {
  BumpState& bump = state_.bumps[touch.body];
  bump.triangle = touch.triangle = state_.contact.holding[held].triangle;
  bump.clear_m = 0;
  touch.heightOnly = true;
  touch.normal = heldNormal(state_, held);
  touch.geometric_m = partOf(state_, held, held_m_);
  touch.from = state_.estimate.hip + held_m_ - touch.geometric_m * touch.normal;
  return hasTexture(touch.body);
}

bool SurfaceForceModel::findNearestPoint(SurfaceContact& touch) noexcept {
  BumpState& bump = state_.bumps[touch.body];
  const Body& body = state_.bodies[touch.body];
  const CollisionMesh& surface = *body.surface;
  touch.from = contact_.touching ? contact_.ihip : state_.estimate.hip;
  const Vec3 h = body.frame.toLocal(touch.from);
  const bool isDented = object(touch.body).tissue && dentsOf(state_, touch.body).count > 0;
  if (!isDented && squaredLength(h - bump.seenFrom) < bump.clear_m * bump.clear_m) return false;
  const double reach_m = detail(touch.body)->reach_m;
  const double lookAhead_m = reach_m + kLookAhead * surface.radius_m();
  NearPlace near{nearestPoint(surface, h, lookAhead_m, bump.triangle, contact_.work.allowance)};
  const double asked_N = detail(touch.body)->scalars.adhesion_N;
  if (contact_.work.allowance.isSpent()) {
    if (asked_N > 0) state_.fallBehind(contact_.work);
    return false;
  }
  if (near.foot.triangle != kNoTriangle) {
    near.normal = surface.normal(near.foot);
    near.side = surface.closed() || glm::dot(near.normal, h - near.foot.point) >= 0 ? 1 : -1;
    near.isOutside = !surface.closed() || surface.isOutside(near.foot, h);
  }
  if (isDented) moveOntoDents(near, touch.body, h);
  const auto& [foot, normal, side, isOutside] = near;
  const double distance_m = foot.triangle == kNoTriangle ? lookAhead_m : std::sqrt(foot.squaredDistance);
  const std::uint32_t last = bump.triangle;
  const Vec3 seenFrom = bump.seenFrom;
  bump.triangle = foot.triangle;
  bump.seenFrom = h;
  bump.clear_m = isDented ? 0 : std::max(0.0, distance_m - reach_m);
  if (distance_m >= reach_m) {
    bump.blendWeight = 1;
    return false;
  }
  if (!isOutside) {
    bump.blendWeight = 0;  // got in without touching: the way out is free too
    return false;
  }
  touch.triangle = foot.triangle;
  touch.geometric_m = -distance_m;
  touch.normal = body.frame.rotate(exceedsRounding(distance_m, touch.body) ? (h - foot.point) / distance_m
                                                                           : normal * double(side));
  if (asked_N > 0) [[unlikely]] {
    result_.force.spring -= adhesionAt(distance_m, asked_N, config_.stableLateral_N_per_m) * touch.normal;
    const bool wasTouched = memory_.object == object(touch.body).id;
    // In a groove the nearest point jumps, and past the edge of a thin body the HIP is outside at once. What the pull then
    // changes is let in as an edit's change is.
    if (wasTouched ? distance_m > kUsualWay_m : jumps(foot, surface, last, h, glm::distance(h, seenFrom)))
      state_.limits.slew.begin();
  }
  touch.inHollow = isDented && !contact_.touching;
  const Vec3 unshaded = touch.normal;
  touch.shaded = hasShading(touch.body) && shadeAt(touch, foot, side);
  if (touch.inHollow) fadeShading(touch, ShadingFade::Mode::kHollow, unshaded, -distance_m);
  return true;
}

void SurfaceForceModel::moveOntoDents(NearPlace& near, std::size_t body, const Vec3& h) noexcept {
  // In the hollow of a dent, the shape without dents holds the IHIP still.
  if (const auto held = heldSurfaceOf(state_.contact, body)) {
    near.foot.triangle = state_.contact.holding[*held].triangle;
    near.side = state_.contact.holding[*held].side;
  }
  if (near.foot.triangle == kNoTriangle) return;
  const PressedBody dented{.body = body, .atRest = near.foot, .side = near.side, .h = h, .below = true};
  const DentSolver::Nearest at = DentSolver(scene_, state_, config_, contact_.work, dented).nearestTo(h);
  near.foot = at.foot;
  near.normal = at.normal * double(near.side);
  near.isOutside = !state_.bodies[body].surface->closed() || at.outside;
}

/// Height and depth, and speed.
void SurfaceForceModel::addTextureHeight(SurfaceContact& touch, BumpState& bump) noexcept {
  const Body& body = state_.bodies[touch.body];
  const double polygon_m = touch.geometric_m;
  touch.geometric_m += touch.bulge_m * bump.blendWeight;
  double full_m = 0;
  if (hasTexture(touch.body) && (touch.heightOnly || !isTouched(touch.body) || !severalBodiesHold(state_))) {
    contact_.work.allowance.spend(kField);
    const Vec3 place = body.frame.toLocal(touch.ihip());
    const HeightSample local = isDeformed(scene_, state_, touch.body) ? reliefOnMaterial(touch, place)
                                                                      : detail(touch.body)->texture->at(place);
    full_m = local.height_m;
    if (state_.now.detailEdited && object(touch.body).id == state_.report.object) rescaleAfterEdit(bump, full_m);
    touch.height_m = local.height_m * bump.blendWeight;
    touch.gradient = body.frame.rotate(local.gradient) * bump.blendWeight;
  }
  touch.depth_m = texturedDepth(touch.height_m, -touch.geometric_m);
  bump.height_m = touch.height_m;
  const bool reaches = texturedDepth(full_m + touch.bulge_m, -polygon_m) > 0;
  const double most = config_.period_s / BumpState::kFadeIn_s;
  bump.blendWeight += reaches ? std::clamp(1 - bump.blendWeight, -most, most) : 1 - bump.blendWeight;
  touch.speed_m_per_s =
      separationSpeed(state_, static_cast<int>(touch.body), touch.ihip(), touch.normal, config_.period_s);
}

/// Height and gradient of the texture at the IHIP, in the object's frame.
HeightSample SurfaceForceModel::reliefOnMaterial(const SurfaceContact& touch, const Vec3& place) noexcept {
  const TextureDetail& texture = *detail(touch.body)->texture;
  if (isTouched(touch.body) && state_.features.soft && state_.deformedContact.isLevel && !detail(touch.body)->material)
    return texture.at(state_.deformedContact.foot);
  dented_ = dentedTriangle(scene_, state_, touch.body, touch.triangle);
  dentedBody_ = touch.body;
  dentedIndex_ = touch.triangle;
  const TriangleMap map = mapToMaterial(scene_, state_, touch.body, touch.triangle, dented_);
  const HeightSample relief = texture.at(map.place(place));
  return {relief.height_m, map.gradient(relief.gradient)};
}

}  // namespace haptics
