#include <algorithm>

#include "haptic_server/force/output_chain.h"
#include "haptic_server/servo/body_dents.h"
#include "haptic_server/servo/feel_details.h"
#include "haptic_server/servo/groove_shading.h"
#include "haptic_server/servo/soft_contact.h"
#include "haptic_server/surface/force_shading.h"

namespace haptics {

void Feeling::addShading() noexcept {
  if (!contact_.touching) return;
  Felt& felt = felt_[count_++];
  felt = {};
  felt.body = static_cast<std::size_t>(contact_.body);
  felt.triangle = contact_.triangle == kNoTriangle ? state_.contact.holding[0].triangle : contact_.triangle;
  felt.from = state_.estimate.hip;
  felt.geometric_m = contact_.penetration_m;
  const bool alongWay = !contact_.alongNormal && tellsDirection(felt.geometric_m, felt.body);
  felt.normal = alongWay ? (contact_.ihip - state_.estimate.hip) / felt.geometric_m : contact_.normal;
  unshaded_m_ = felt.geometric_m * felt.normal;
  shadeTouched(felt);
  if (state_.features.varyingStiffness && isShadedRigid(felt.body)) varyBeside(felt);
}

/// With force shading where there is a shading normal, and without a step where that begins or ends.
void Feeling::shadeTouched(Felt& felt) noexcept {
  ShadingFade& fade = memory_.fade;
  const Feature feature = contact_.triangle == kNoTriangle ? state_.contact.feature : featureOf(contact_.primitive);
  const Vec3 unshaded = felt.normal;
  const double unshaded_m = felt.geometric_m;
  ShadingFade::How how = ShadingFade::How::kNot;
  if (severalBodiesHold(state_)) {
    if (shadeTogether(felt)) how = ShadingFade::How::kTogether;
  } else if (state_.features.soft && state_.yielded.between) {
    how = ShadingFade::How::kBetween;
  } else if (hasShading(felt.body) && state_.contact.mode == ContactState::Mode::kOneSurface &&
             shadeAt(felt, {felt.triangle, feature, contact_.primitive.localIndex}, state_.contact.holding[0].side)) {
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
  } else if (how != fade.how || state_.adoption.detailEdited) {
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

/// Of several bodies that hold the IHIP.
bool Feeling::shadeTogether(Felt& felt) noexcept {
  Vec3 ihip = contact_.ihip;
  if (!shadeGroove(scene_, state_, ihip, contact_.work)) return false;
  held_m_ = ihip - state_.estimate.hip;
  felt.geometric_m = glm::length(held_m_);
  if (felt.geometric_m > 0) felt.normal = held_m_ / felt.geometric_m;
  return true;
}

bool Feeling::shadeAt(Felt& felt, const Foot& foot, int side) const noexcept {
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

ShadedPoint Feeling::shadeDented(const Felt& felt, const SoftTissue& tissue, const Foot& foot, const Vec3& h,
                                 double depth_m) const noexcept {
  return shade(*state_.bodies[felt.body].surface, *detail(felt.body)->shading, dentsOf(state_, felt.body).all(),
               tissue.falloff, foot, h, depth_m);
}

/// Between one body and several, whose bulges are felt one by one before they hold the IHIP together, the whole of the
/// springs' force fades.
void Feeling::fadeSwitch() noexcept {
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
double Feeling::mostSwitched_N() const noexcept {
  if (state_.features.soft) return config_.maxForce_N;
  double most_N = 0;
  for (std::size_t i = 0; i < state_.adoption.bodyCount; ++i) {
    if (hasShading(i)) most_N += state_.objects[i].felt.value().spring_N_per_m * detail(i)->highest_m();
  }
  return most_N;
}

}  // namespace haptics
