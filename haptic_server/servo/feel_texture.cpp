#include <algorithm>
#include <cmath>

#include "haptic_server/servo/feel_details.h"
#include "haptic_server/servo/material_map.h"
#include "haptic_server/servo/separation_speed.h"
#include "haptic_server/surface/nearest_point.h"

namespace haptics {
namespace {

/// Units (Allowance) of a texture's field: a sum of 64 waves.
constexpr std::int64_t kField = 600;
/// Of a surface's size, how much farther than its highest bump reaches its nearest point is looked for. Larger looks
/// less often and farther each time.
constexpr double kLookAhead = 0.02;

/// After an edit: the part of the new height that is what was felt of the old one. Of a lower one it would be more than
/// all, that is a steeper texture than anybody asked for: that step is EditSlew's.
void goOnFrom(BumpWatch& watch, double height_m) noexcept {
  const double part = watch.height_m / height_m;
  watch.presence = std::isfinite(part) ? std::clamp(part, 0.0, 1.0) : 0;
}

}  // namespace

void Feeling::addTexture() noexcept {
  if (contact_.touching) {
    Felt& felt = felt_[0];
    BumpWatch& watch = state_.bumps[felt.body];
    watch.triangle = felt.triangle;
    watch.clear_m = 0;
    feelHeight(felt, watch);
    const Vec3 shaded_m = std::max(0.0, felt.geometric_m) * felt.normal;
    tick_.shadingForce_N = stiffness(felt).spring_N_per_m * (shaded_m - unshaded_m_);
  }
  if (state_.features.bumps) feelBumps();
}

void Feeling::feelBumps() noexcept {
  for (std::size_t i = 0; i < state_.adoption.bodyCount && count_ < kMostFelt; ++i) {
    if (detail(i) == nullptr || !(detail(i)->highest_m() > 0) || state_.bodies[i].leaving) continue;
    if (isTouched(i) && !severalBodiesHold(state_)) continue;
    if (contact_.work.allowance.isSpent()) return state_.fallBehind(contact_.work);
    Felt felt{};
    felt.body = i;
    if (!nearBumps(felt)) continue;
    if (state_.features.varyingStiffness && !felt.heightOnly) varyBeside(felt);
    feelHeight(felt, state_.bumps[i]);
    if (!(felt.depth_m > 0)) continue;
    // Where the polygons are touched next, shading goes on.
    if (count_ == 0) memory_.fade = {.how = felt.shaded ? ShadingFade::How::kAlone : ShadingFade::How::kNot};
    felt_[count_++] = felt;
  }
}

/// Looks for the nearest point of a surface that is not touched, or, when it is one of several that are, takes it.
bool Feeling::nearBumps(Felt& felt) noexcept {
  BumpWatch& watch = state_.bumps[felt.body];
  const Body& body = state_.bodies[felt.body];
  const Surface& surface = *body.surface;
  // Of several triangles of a body always the same one, whatever order they are in.
  const auto holding = state_.contact.surfaces();
  std::size_t held = holding.size();
  for (std::size_t k = 0; k < holding.size(); ++k) {
    if (static_cast<std::size_t>(holding[k].body) != felt.body) continue;
    if (held == holding.size() || holding[k].triangle < holding[held].triangle) held = k;
  }
  if (held < holding.size()) {
    watch.triangle = felt.triangle = holding[held].triangle;
    watch.clear_m = 0;
    felt.heightOnly = true;
    felt.normal = heldNormal(state_, held);
    felt.geometric_m = partOf(state_, held, held_m_);
    felt.from = state_.estimate.hip + held_m_ - felt.geometric_m * felt.normal;
    return hasTexture(felt.body);
  }
  felt.from = contact_.touching ? contact_.ihip : state_.estimate.hip;
  const Vec3 h = body.frame.toLocal(felt.from);
  if (squaredLength(h - watch.seenFrom) < watch.clear_m * watch.clear_m) return false;
  const double highest_m = detail(felt.body)->highest_m();
  const double reach_m = highest_m + kLookAhead * surface.radius_m();
  const Foot foot = nearestPoint(surface, h, reach_m, watch.triangle, contact_.work.allowance);
  if (contact_.work.allowance.isSpent()) return false;
  const double distance_m = foot.triangle == kNoTriangle ? reach_m : std::sqrt(foot.squaredDistance);
  watch.triangle = foot.triangle;
  watch.seenFrom = h;
  watch.clear_m = std::max(0.0, distance_m - highest_m);
  if (distance_m >= highest_m) {
    watch.presence = 1;
    return false;
  }
  if (surface.closed() && !surface.isOutside(foot, h)) {
    watch.presence = 0;  // got in without touching: the way out is free too
    return false;
  }
  const Vec3 normal = surface.normal(foot);
  const int side = surface.closed() || glm::dot(normal, h - foot.point) >= 0 ? 1 : -1;
  felt.triangle = foot.triangle;
  felt.geometric_m = -distance_m;
  felt.normal =
      body.frame.turn(tellsDirection(distance_m, felt.body) ? (h - foot.point) / distance_m : normal * double(side));
  felt.shaded = hasShading(felt.body) && shadeAt(felt, foot, side);
  return true;
}

/// Height and depth, and speed.
void Feeling::feelHeight(Felt& felt, BumpWatch& watch) noexcept {
  const Body& body = state_.bodies[felt.body];
  const double polygon_m = felt.geometric_m;
  felt.geometric_m += felt.bulge_m * watch.presence;
  double full_m = 0;
  if (hasTexture(felt.body) && (felt.heightOnly || !isTouched(felt.body) || !severalBodiesHold(state_))) {
    contact_.work.allowance.spend(kField);
    const Vec3 place = body.frame.toLocal(felt.ihip());
    const Relief local =
        isDeformed(scene_, state_, felt.body) ? reliefOnMaterial(felt, place) : detail(felt.body)->texture->at(place);
    full_m = local.height_m;
    if (state_.adoption.detailEdited && object(felt.body).id == state_.report.object) goOnFrom(watch, full_m);
    felt.height_m = local.height_m * watch.presence;
    felt.gradient = body.frame.turn(local.gradient) * watch.presence;
  }
  felt.depth_m = texturedDepth(felt.height_m, -felt.geometric_m);
  watch.height_m = felt.height_m;
  const bool reaches = texturedDepth(full_m + felt.bulge_m, -polygon_m) > 0;
  const double most = config_.period_s / BumpWatch::kFadeIn_s;
  watch.presence += reaches ? std::clamp(1 - watch.presence, -most, most) : 1 - watch.presence;
  felt.speed_m_per_s = separationSpeed(state_, static_cast<int>(felt.body), felt.ihip(), felt.normal, config_.period_s);
}

/// Of the texture at the IHIP; place and relief in the object's frame.
Relief Feeling::reliefOnMaterial(const Felt& felt, const Vec3& place) noexcept {
  const TextureDetail& texture = *detail(felt.body)->texture;
  if (isTouched(felt.body) && state_.features.soft && state_.yielded.isLevel && !detail(felt.body)->material)
    return texture.at(state_.yielded.foot);
  now_ = feltTriangle(scene_, state_, felt.body, felt.triangle);
  nowBody_ = felt.body;
  nowTriangle_ = felt.triangle;
  const TriangleMap map = mapToMaterial(scene_, state_, felt.body, felt.triangle, now_);
  const Relief relief = texture.at(map.place(place));
  return {relief.height_m, map.gradient(relief.gradient)};
}

}  // namespace haptics
