#include "haptic_server/servo/feel_details.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "haptic_server/force/output_chain.h"
#include "haptic_server/servo/body_dents.h"
#include "haptic_server/servo/feel_friction.h"
#include "haptic_server/servo/groove_shading.h"
#include "haptic_server/servo/held_springs.h"
#include "haptic_server/servo/material_map.h"
#include "haptic_server/servo/separation_speed.h"
#include "haptic_server/servo/soft_contact.h"
#include "haptic_server/servo/varying_springs.h"
#include "haptic_server/surface/force_shading.h"
#include "haptic_server/surface/nearest_point.h"

namespace haptics {
namespace {

/// Objects felt at once, beside the touched one those whose bumps reach the HIP. More are left out.
constexpr std::size_t kMostFelt = 8;
/// Units (Allowance) of a texture's field: a sum of 64 waves.
constexpr std::int64_t kField = 600;
/// Of a surface's size, how much farther than its highest bump reaches its nearest point is looked for. Larger looks
/// less often and farther each time.
constexpr double kLookAhead = 0.02;

/// A surface as it is felt in this tick; world frame. Without initialisers: not all of the list is used.
struct Felt {
  std::size_t body;
  std::uint32_t triangle;
  Vec3 from;           ///< The HIP; the IHIP on another body, where that is what comes near this one.
  Vec3 normal;         ///< N_s, unit, towards the hand.
  double geometric_m;  ///< Depth of `from` below the geometric surface along it; negative outside.
  double bulge_m;      ///< Of shading, beyond that; feelHeight() adds it to the depth.
  double height_m;     ///< Of the texture.
  Vec3 gradient;
  double depth_m;  ///< d: below the textured surface.
  double speed_m_per_s;
  bool shaded;      ///< N_s is a shading normal.
  bool heightOnly;  ///< One of several bodies that hold the IHIP: what is without the height is felt with the first.

  [[nodiscard]] Vec3 ihip() const noexcept { return from + geometric_m * normal; }
};

class Feeling {
 public:
  Feeling(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick) noexcept
      : scene_(scene),
        state_(state),
        memory_(state.surface),
        config_(config),
        contact_(tick.contact),
        tick_(tick),
        held_m_(tick.contact.ihip - state.hip) {}

  void run() noexcept {
    if (contact_.touching) feelTouched();
    if (state_.anyBumps) feelBumps();
    followStiffness();
    for (std::size_t i = 0; i < count_; ++i) addForce(felt_[i]);
    if (state_.anyVaryingStiffness) pushAlong();
    if (severalBodiesHold(state_)) tick_.force.spring += otherSprings_N(state_, held_m_);
    if (count_ == 0) {
      forgetFriction();
      memory_.object = 0;
      return;
    }
    if (state_.bodyCount > 1) fadeSwitch();
    const Felt& first = felt_[0];
    addFriction(first);
    describe(first);
  }

 private:
  [[nodiscard]] const ServoObject& object(std::size_t body) const noexcept { return scene_.objects[body]; }
  [[nodiscard]] const SurfaceDetail* detail(std::size_t body) const noexcept { return object(body).detail.get(); }
  [[nodiscard]] bool hasTexture(std::size_t body) const noexcept {
    return detail(body) != nullptr && detail(body)->texture.has_value();
  }
  [[nodiscard]] bool hasShading(std::size_t body) const noexcept {
    return detail(body) != nullptr && detail(body)->shading != nullptr;
  }
  [[nodiscard]] Stiffness stiffness(const Felt& felt) const noexcept { return state_.objects[felt.body].felt.value(); }

  [[nodiscard]] bool isTouched(std::size_t body) const noexcept {
    return contact_.touching && static_cast<std::size_t>(contact_.body) == body;
  }
  /// Two points this far apart: does their difference say more than how they were rounded? Without a texture it does not
  /// matter, for then the force is as small.
  [[nodiscard]] bool tellsDirection(double apart_m, std::size_t body) const noexcept {
    constexpr double kRounding = 0x1p-30;  // of the coordinates, which leaves the direction 2^-22
    return apart_m > kRounding * state_.bodies[body].extent_m;
  }

  /// What the contact core holds, or is met within its dent: the first of all.
  void feelTouched() noexcept {
    Felt& felt = felt_[count_++];
    felt = {};
    felt.body = static_cast<std::size_t>(contact_.body);
    felt.triangle = contact_.triangle == kNoTriangle ? state_.contact.holding[0].triangle : contact_.triangle;
    felt.from = state_.hip;
    felt.geometric_m = contact_.penetration_m;
    const bool alongWay = !contact_.alongNormal && tellsDirection(felt.geometric_m, felt.body);
    felt.normal = alongWay ? (contact_.ihip - state_.hip) / felt.geometric_m : contact_.normal;
    BumpWatch& watch = state_.bumps[felt.body];
    watch.triangle = felt.triangle;
    watch.clear_m = 0;
    const Vec3 unshaded_m = felt.geometric_m * felt.normal;
    shadeTouched(felt);
    if (state_.anyVaryingStiffness && isShadedRigid(felt.body)) varyBeside(felt);
    feelHeight(felt, watch);
    tick_.shadingForce_N =
        stiffness(felt).spring_N_per_m * (std::max(0.0, felt.geometric_m) * felt.normal - unshaded_m);
  }

  /// What of its triangle holds the IHIP.
  [[nodiscard]] Feature feature() const noexcept {
    return contact_.triangle == kNoTriangle ? state_.contact.feature : featureOf(contact_.primitive);
  }

  /// With force shading where there is a shading normal, and without a step where that begins or ends.
  void shadeTouched(Felt& felt) noexcept {
    ShadingFade& fade = memory_.fade;
    const Vec3 unshaded = felt.normal;
    const double unshaded_m = felt.geometric_m;
    ShadingFade::How how = ShadingFade::How::kNot;
    if (severalBodiesHold(state_)) {
      if (shadeTogether(felt)) how = ShadingFade::How::kTogether;
    } else if (state_.anySoft && state_.yielded.between) {
      how = ShadingFade::How::kBetween;
    } else if (hasShading(felt.body) && state_.contact.mode == ContactState::Mode::kOneSurface &&
               shadeAt(felt, {felt.triangle, feature(), contact_.primitive.localIndex},
                       state_.contact.holding[0].side)) {
      how = ShadingFade::How::kAlone;
    }
    const Vec3 turn = felt.normal - unshaded;
    const double deepening_m = felt.geometric_m + felt.bulge_m - unshaded_m;
    if (memory_.object == 0) {
      fade = {};
    } else if (how != fade.how && std::max(how, fade.how) >= ShadingFade::How::kBetween) {
      fade.turnLeft = Vec3(0);
      fade.deepeningLeft_m = 0;
      switched_ = true;
    } else if (how != fade.how || state_.detailEdited) {
      fade.turnLeft += fade.turn - turn;
      fade.deepeningLeft_m += fade.deepening_m - deepening_m;
    }
    fade.how = how;
    fade.turn = turn;
    fade.deepening_m = deepening_m;
    if (fade.turnLeft == Vec3(0) && fade.deepeningLeft_m == 0) return;
    felt.normal = unitOrZero(felt.normal + fade.turnLeft);
    felt.geometric_m += fade.deepeningLeft_m;
    const double left = 1 - std::min(1.0, config_.period_s / ShadingFade::kTime_s);
    fade.turnLeft *= left;
    fade.deepeningLeft_m *= left;
  }

  /// Between one body and several, whose bulges are felt one by one before they hold the IHIP together, the whole of the
  /// springs' force fades.
  void fadeSwitch() noexcept {
    ShadingFade& fade = memory_.fade;
    if (memory_.object == 0) fade.left_N = Vec3(0);
    const Vec3 now_N = tick_.force.spring;
    if (switched_)
      fade.left_N = limitMagnitude(fade.springs_N + fade.change_N - now_N, mostSwitched_N());  // had it gone on
    tick_.force.spring += fade.left_N;
    fade.left_N *= 1 - std::min(1.0, config_.period_s / ShadingFade::kTime_s);
    fade.change_N = memory_.object == 0 ? Vec3(0) : tick_.force.spring - fade.springs_N;
    fade.springs_N = tick_.force.spring;
  }

  /// What a switch can change: rigid bodies without a bulge are the same alone and together.
  [[nodiscard]] double mostSwitched_N() const noexcept {
    if (state_.anySoft) return config_.maxForce_N;
    double most_N = 0;
    for (std::size_t i = 0; i < state_.bodyCount; ++i) {
      if (hasShading(i)) most_N += state_.objects[i].felt.value().spring_N_per_m * detail(i)->highest_m();
    }
    return most_N;
  }

  /// Of several bodies that hold the IHIP.
  [[nodiscard, gnu::noinline]] bool shadeTogether(Felt& felt) noexcept {
    Vec3 ihip = contact_.ihip;
    if (!shadeGroove(scene_, state_, ihip, contact_.work)) return false;
    held_m_ = ihip - state_.hip;
    felt.geometric_m = glm::length(held_m_);
    if (felt.geometric_m > 0) felt.normal = held_m_ / felt.geometric_m;
    return true;
  }

  /// Paper 4.1. Returns whether there is a shading normal.
  [[nodiscard]] bool shadeAt(Felt& felt, const Foot& foot, int side) const noexcept {
    const Body& body = state_.bodies[felt.body];
    const ShadingNormals& normals = *detail(felt.body)->shading;
    const Vec3 h = body.frame.toLocal(felt.from);
    const SoftTissue* tissue = object(felt.body).tissue.get();
    const ShadedPoint point = tissue == nullptr ? shade(*body.surface, normals, foot, h, felt.geometric_m * side)
                              : isTouched(felt.body) && state_.yielded.shaded.weight > 0
                                  ? state_.yielded.shaded
                                  : shadeDented(felt, *tissue, foot, h, felt.geometric_m * side);
    if (!(point.weight > 0)) return false;
    felt.triangle = point.triangle;
    const Vec3 smooth = body.frame.turn(point.normal) * double(side);
    felt.normal = point.weight < 1 ? glm::normalize(glm::mix(felt.normal, smooth, point.weight)) : smooth;
    felt.geometric_m = glm::mix(felt.geometric_m, point.depth_m * side, point.weight);
    felt.bulge_m = point.bulge_m * side * point.weight;
    if (tissue != nullptr) {
      felt.bulge_m = yieldedBulge_m(scene_, state_, felt.body, felt.triangle, felt.ihip(), felt.bulge_m);
    }
    return true;
  }

  [[nodiscard, gnu::noinline]] ShadedPoint shadeDented(const Felt& felt, const SoftTissue& tissue, const Foot& foot,
                                                       const Vec3& h, double depth_m) const noexcept {
    return shade(*state_.bodies[felt.body].surface, *detail(felt.body)->shading, dentsOf(state_, felt.body).all(),
                 tissue.falloff, foot, h, depth_m);
  }

  /// Paper 4.3.1: "there may be a collision between the HIP and the texture-mapped surface even when no collision exists
  /// between the HIP and the original surface".
  void feelBumps() noexcept {
    for (std::size_t i = 0; i < state_.bodyCount && count_ < kMostFelt; ++i) {
      if (detail(i) == nullptr || !(detail(i)->highest_m() > 0) || state_.bodies[i].leaving) continue;
      if (isTouched(i) && !severalBodiesHold(state_)) continue;
      if (contact_.work.allowance.isSpent()) return state_.fallBehind(contact_.work);
      Felt felt{};
      felt.body = i;
      if (!nearBumps(felt)) continue;
      if (state_.anyVaryingStiffness && !felt.heightOnly) varyBeside(felt);
      feelHeight(felt, state_.bumps[i]);
      if (!(felt.depth_m > 0)) continue;
      // Where the polygons are touched next, shading goes on.
      if (count_ == 0) memory_.fade = {.how = felt.shaded ? ShadingFade::How::kAlone : ShadingFade::How::kNot};
      felt_[count_++] = felt;
    }
  }

  [[nodiscard]] bool hasVaryingStiffness(std::size_t body) const noexcept {
    return detail(body) != nullptr && detail(body)->stiffness.has_value();
  }

  /// Its stiffness is that of the shaded point.
  [[nodiscard]] bool isShadedRigid(std::size_t body) const noexcept {
    return memory_.fade.how == ShadingFade::How::kAlone && object(body).tissue == nullptr;
  }

  /// To the stiffness at what is felt: a bump that reaches the HIP, or a shaded point.
  void varyBeside(const Felt& felt) noexcept {
    if (!hasVaryingStiffness(felt.body)) return;
    state_.objects[felt.body].felt.vary(
        stiffnessFactorAt(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.ihip()).value);
  }

  /// What stiffnesses that vary push along their surfaces.
  [[gnu::noinline]] void pushAlong() noexcept {
    for (const Felt& felt : std::span(felt_).first(count_)) {
      if (felt.heightOnly || !hasVaryingStiffness(felt.body)) continue;
      const bool held = isTouched(felt.body);
      if (held && !isShadedRigid(felt.body)) continue;
      FactorSample sample = stiffnessFactorAt(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.ihip());
      sample.gradient -= felt.normal * glm::dot(sample.gradient, felt.normal);
      if (held) {
        sample.gradient = belowShaded(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.depth_m,
                                      felt.normal, sample.gradient);
      }
      tick_.force.spring += haptics::pushAlong_N(*detail(felt.body)->stiffness, sample,
                                                 state_.objects[felt.body].felt.mean().spring_N_per_m,
                                                 felt.depth_m * felt.depth_m, config_);
    }
    const auto holding = state_.contact.surfaces();
    const bool byCore = contact_.touching && !holding.empty() && holding.front().body == contact_.body;
    if (!byCore || (!severalBodiesHold(state_) && isShadedRigid(felt_[0].body))) return;
    tick_.force.spring += contactPushAlong_N(scene_, state_, config_, held_m_, std::max(0.0, felt_[0].depth_m));
  }

  /// Looks for the nearest point of a surface that is not touched, or, when it is one of several that are, takes it.
  [[nodiscard]] bool nearBumps(Felt& felt) noexcept {
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
      felt.from = state_.hip + held_m_ - felt.geometric_m * felt.normal;
      return hasTexture(felt.body);
    }
    felt.from = contact_.touching ? contact_.ihip : state_.hip;
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

  /// Height and depth (paper 4.3.1), and speed.
  void feelHeight(Felt& felt, BumpWatch& watch) noexcept {
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
      if (state_.detailEdited && object(felt.body).id == state_.contactObject) goOnFrom(watch, full_m);
      felt.height_m = local.height_m * watch.presence;
      felt.gradient = body.frame.turn(local.gradient) * watch.presence;
    }
    felt.depth_m = texturedDepth(felt.height_m, -felt.geometric_m);
    watch.height_m = felt.height_m;
    const bool reaches = texturedDepth(full_m + felt.bulge_m, -polygon_m) > 0;
    const double most = config_.period_s / BumpWatch::kFadeIn_s;
    watch.presence += reaches ? std::clamp(1 - watch.presence, -most, most) : 1 - watch.presence;
    felt.speed_m_per_s =
        separationSpeed(state_, static_cast<int>(felt.body), felt.ihip(), felt.normal, config_.period_s);
  }

  /// Of the texture at the IHIP; place and relief in the object's frame.
  [[nodiscard, gnu::noinline]] Relief reliefOnMaterial(const Felt& felt, const Vec3& place) noexcept {
    const TextureDetail& texture = *detail(felt.body)->texture;
    if (isTouched(felt.body) && state_.anySoft && state_.yielded.isLevel && !detail(felt.body)->material)
      return texture.at(state_.yielded.foot);
    now_ = feltTriangle(scene_, state_, felt.body, felt.triangle);
    nowBody_ = felt.body;
    nowTriangle_ = felt.triangle;
    const TriangleMap map = mapToMaterial(scene_, state_, felt.body, felt.triangle, now_);
    const Relief relief = texture.at(map.place(place));
    return {relief.height_m, map.gradient(relief.gradient)};
  }

  /// After an edit: the part of the new height that is what was felt of the old one. Of a lower one it would be more than
  /// all, that is a steeper texture than anybody asked for: that step is EditSlew's.
  static void goOnFrom(BumpWatch& watch, double height_m) noexcept {
    const double part = watch.height_m / height_m;
    watch.presence = std::isfinite(part) ? std::clamp(part, 0.0, 1.0) : 0;
  }

  /// Moves every object's felt stiffness towards its own.
  void followStiffness() noexcept {
    if (state_.lettingGo) fadeHeld(state_, config_, held_m_);
    for (std::size_t i = 0; i < state_.bodyCount; ++i) {
      const Stiffness own{object(i).stiffness_N_per_m, object(i).damping_Ns_per_m};
      const Stiffness target = state_.bodies[i].leaving ? Stiffness{} : own;
      if (state_.objects[i].felt.mean() == target && !state_.lettingGo) continue;
      followStiffness(i, target);
    }
  }

  [[gnu::noinline]] void followStiffness(std::size_t i, Stiffness target) noexcept {
    const bool holds = holdsIhip(state_, i);
    if (state_.lettingGo && holds) return;
    const auto end = felt_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto felt = std::find_if(felt_.begin(), end, [i](const Felt& f) { return f.body == i; });
    const bool shares = holds && severalBodiesHold(state_) && !hasTexture(i);
    const double depth_m = shares ? heldDepth_m(state_, i, held_m_) : felt != end ? felt->depth_m : 0;
    const double put_J = state_.objects[i].felt.follow(target, depth_m, felt != end ? felt->speed_m_per_s : 0,
                                                       config_.maxForce_N, config_.period_s);
    if (put_J == 0) return;
    state_.energy.name(object(i).id, EnergyFeature::kEdit, put_J);
    state_.slew.begin();
  }

  /// Spring along N_s and what the texture makes of it (paper 4.3.2), and the damper.
  void addForce(const Felt& felt) noexcept {
    const Stiffness k = stiffness(felt);
    const auto along = springDamper(felt.depth_m, felt.normal, felt.speed_m_per_s, k);
    if (!felt.heightOnly && (felt.depth_m > 0 || detail(felt.body) == nullptr)) {
      tick_.force.damping += along.damping;
    }
    if (!hasTexture(felt.body)) {
      tick_.force.spring += along.spring;
      return;
    }
    const TextureDetail& t = *detail(felt.body)->texture;
    const Relief relief{felt.height_m, felt.gradient};
    const double most = config_.stableLateral_N_per_m;
    const Vec3 way =
        t.law() == Texture::Law::kBump
            ? bumpForce(felt.depth_m, felt.normal,
                        {relief.height_m, relief.gradient * t.slopePartFor(felt.depth_m, k.spring_N_per_m, most)})
            : hoForce(felt.depth_m, felt.normal, relief, t.gainFor(k.spring_N_per_m, most));
    const Vec3 smooth_m = std::max(0.0, felt.geometric_m) * felt.normal;
    if (!felt.heightOnly) tick_.force.spring += k.spring_N_per_m * smooth_m;
    tick_.force.texture += k.spring_N_per_m * (way - smooth_m);
  }

  /// Paper 4.2, on what is touched, or on the bump that reaches the HIP.
  void addFriction(const Felt& felt) noexcept {
    memory_.object = object(felt.body).id;
    const bool onSeveral = state_.contact.holdingCount > 1 && isTouched(felt.body);
    if (!onSeveral && (detail(felt.body) == nullptr || !detail(felt.body)->friction)) {
      forgetFriction();
      return;
    }
    const auto along = springDamper(felt.depth_m, felt.normal, felt.speed_m_per_s, stiffness(felt));
    const double pressing_N = felt.depth_m > 0 ? std::max(0.0, glm::dot(along.spring + along.damping, felt.normal)) : 0;
    const bool isKnown = felt.body == nowBody_ && felt.triangle == nowTriangle_;
    const PressedSurface all{felt.body, felt.triangle, felt.normal, pressing_N, isKnown ? &now_ : nullptr};
    if (onSeveral) {
      feelFrictionOnEach(all, felt.ihip());
    } else {
      feelFriction(scene_, state_, config_, felt.ihip(), {&all, 1}, tick_);
    }
  }

  void forgetFriction() noexcept {
    if (memory_.friction[0].object != 0) memory_.friction = {};
  }

  /// On each surface that holds the IHIP, with its part of what presses.
  [[gnu::noinline]] void feelFrictionOnEach(const PressedSurface& all, const Vec3& ihip) noexcept {
    const auto holding = state_.contact.surfaces();
    std::array<PressedSurface, ContactState::kMaxHolding> pressed;
    const Vec3 springs_N = springsThatHold(state_).force_N(held_m_);
    double together_N2 = 0;
    for (std::size_t k = 0; k < holding.size(); ++k) {
      const auto body = static_cast<std::size_t>(holding[k].body);
      pressed[k] = {body, holding[k].triangle, heldNormal(state_, k), std::max(0.0, partOf(state_, k, springs_N))};
      together_N2 += pressed[k].pressing_N * glm::dot(pressed[k].normal, springs_N);
    }
    // Parts add up to the springs' force, but for normals that are too close together to tell them apart.
    const double first_N = state_.objects[all.body].felt.value().spring_N_per_m * glm::length(held_m_);
    const double pressing =
        together_N2 * first_N > 0 ? all.pressing_N / first_N * squaredLength(springs_N) / together_N2 : 0;
    for (PressedSurface& surface : pressed) surface.pressing_N *= pressing;
    feelFriction(scene_, state_, config_, ihip, std::span(pressed).first(holding.size()), tick_);
  }

  void describe(const Felt& felt) noexcept {
    const Body& body = state_.bodies[felt.body];
    contact_.ihip = felt.ihip();
    contact_.normal = felt.normal;
    contact_.penetration_m = felt.depth_m;
    if (!contact_.touching) {
      contact_.touching = true;
      contact_.body = static_cast<int>(felt.body);
      contact_.primitive = {PrimitiveKind::kPolygon, 0, body.surface->canonical(felt.triangle)};
    }
    tick_.height_m = felt.height_m;
  }

  const ServoScene& scene_;
  HapticState& state_;
  SurfaceMemory& memory_;
  const StepConfig& config_;
  ContactResult& contact_;
  FeltTick& tick_;
  Vec3 held_m_;  // from the HIP to the IHIP of the contact core
  std::array<Felt, kMostFelt> felt_;
  std::size_t count_ = 0;
  TriangleRecord now_;  // as dents have it: the last that was asked for
  std::size_t nowBody_ = 0;
  bool switched_ = false;  // from one body's shading to that of several together, or back
  std::uint32_t nowTriangle_ = kNoTriangle;
};

}  // namespace

void feelDetails(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& felt) noexcept {
  Feeling(scene, state, config, felt).run();
}

}  // namespace haptics
