#include "haptic_server/servo/soft_bodies.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "haptic_server/servo/held_springs.h"
#include "haptic_server/servo/relaxing_dents.h"
#include "haptic_server/servo/varying_springs.h"
#include "haptic_server/servo/yielding.h"

namespace haptics {
namespace {

/// Rounds in which the IHIP is looked for on several dented surfaces: they are not flat.
constexpr int kRounds = 2;
/// Of a length: what surfaces whose normals are the same are told apart by. Larger leaves the IHIP below them.
constexpr double kRegular = 1e-9;

/// The dents leave the HIP outside of a body. What reaches into the dent is met there, on the way from the surface at rest.
void lose(HapticState& state, std::size_t body, ContactResult& contact) noexcept {
  const Vec3 rest = contact.ihip;
  state.release();
  contact.touching = contact.alongNormal = false;
  contact.body = -1;
  contact.ihip = state.hip;
  contact.normal = Vec3(0);
  contact.penetration_m = 0;
  contact.primitive = {};
  contact.triangle = kNoTriangle;
  const InTheWay met = firstInTheWay(state, body, rest, state.hip);
  if (!met.crossing) return;
  const Body& other = state.bodies[met.body];
  contact.touching = true;
  contact.body = static_cast<int>(met.body);
  contact.ihip = met.point;
  contact.normal = other.frame.turn(other.surface->faceNormal(met.crossing.triangle) * double(met.crossing.side));
  contact.penetration_m = glm::distance(contact.ihip, state.hip);
  contact.primitive = primitiveOf(*other.surface, Foot{met.crossing.triangle});
  contact.triangle = met.crossing.triangle;
}

/// Of the tissue's stiffness, at a place on the shape at rest; the gradient along the IHIP's ways. 1 where it does not vary.
[[nodiscard]] FactorSample softnessAt(const ServoScene& scene, const HapticState& state, std::size_t body,
                                      std::uint32_t triangle, Vec3 place) noexcept {
  const ServoObject& object = scene.objects[body];
  if (!object.detail || !object.detail->softness) [[likely]]
    return {};
  FactorSample sample = factorAt(*object.detail->softness, object, state.bodies[body], triangle, place,
                                 std::numeric_limits<double>::infinity());
  sample.gradient = alongContact(state, sample.gradient);
  return sample;
}

/// What the tissue pushes along the surface, where it varies.
[[nodiscard]] Vec3 tissuePushAlong_N(const ServoObject& object, const FactorSample& softness, double elastic_m2,
                                     const StepConfig& config) noexcept {
  if (softness.gradient == Vec3(0)) [[likely]]
    return Vec3(0);
  return pushAlong_N(*object.detail->softness, softness, object.tissue->stiffness_N_per_m, elastic_m2, config);
}

/// The body that the contact belongs to.
void yieldAlone(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick) noexcept {
  ContactResult& contact = tick.contact;
  const auto index = static_cast<std::size_t>(contact.body);
  const Body& body = state.bodies[index];
  const HoldingSurface& held = state.contact.holding[0];
  Foot atRest;
  atRest.triangle = held.triangle;
  atRest.feature = state.contact.feature;
  atRest.index = contact.primitive.localIndex;
  atRest.point = body.frame.toLocal(contact.ihip);
  const FactorSample softness = softnessAt(scene, state, index, held.triangle, contact.ihip);
  const PressedBody pressed{.body = index,
                            .atRest = atRest,
                            .side = held.side,
                            .h = body.frame.toLocal(state.hip),
                            .below = contact.penetration_m > 0,
                            .contact_N_per_m = state.objects[index].felt.value().spring_N_per_m,
                            .alone = true,
                            .softness = softness.value};
  Yielding yielding(scene, state, config, contact.work, pressed);
  if (!yielding.press()) return lose(state, index, contact);
  const Yielding::Nearest at = yielding.nearestTo(pressed.h);
  if (at.outside) return lose(state, index, contact);
  tick.force.spring += tissuePushAlong_N(scene.objects[index], softness, yielding.elastic_m2(), config);
  contact.alongNormal = false;
  contact.ihip = body.frame.toWorld(at.foot.point);
  contact.normal = body.frame.turn(at.normal);
  contact.penetration_m = glm::distance(contact.ihip, state.hip);
  contact.primitive = primitiveOf(*body.surface, at.foot);
  contact.triangle = at.foot.triangle;
}

/// Bodies that hold the IHIP together, each of them in series with its own tissue. With p_i the depth of the HIP below
/// surface i at rest, d_i what is left of it for the contact's spring and y_i what the tissue takes,
///   sum_j n_i . n_j d_j + y_i = p_i,  d_i >= 0,
/// for the IHIP, HIP + sum d_j n_j, is on each surface displaced by y_i; and y_i = r_i d_i + a_i, where r = k / t for an
/// elastic tissue and 0 for a rigid body (SoftTissue has the viscous one).
class Together {
 public:
  /// @param inTheWay  Of the one body that holds the IHIP, into another one; or nothing.
  Together(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick,
           const InTheWay& inTheWay) noexcept
      : scene_(scene),
        state_(state),
        config_(config),
        tick_(tick),
        contact_(tick.contact),
        penetration_m_(tick.contact.ihip - state.hip) {
    gather(inTheWay);
  }

  void run() noexcept {
    shareOut();
    for (Part& part : parts()) {
      if (part.tissue != nullptr) press(part);
    }
    settle();
  }

 private:
  /// Of a body that holds the IHIP; world.
  struct Part {
    HoldingSurface held;                 // the first of its surfaces
    Vec3 normal{0};                      // unit
    Vec3 point{0};                       // on its plane at rest
    const SoftTissue* tissue = nullptr;  // null: rigid
    FactorSample softness = {};
    double left_m = 0;   // d
    double yield_m = 0;  // y
  };
  struct Plane {
    Vec3 point{0};
    Vec3 normal{0};
  };

  [[nodiscard]] std::span<Part> parts() noexcept { return std::span(parts_).first(count_); }
  [[nodiscard]] static std::size_t bodyOf(const Part& part) noexcept {
    return static_cast<std::size_t>(part.held.body);
  }
  [[nodiscard]] double spring_N_per_m(const Part& part) const noexcept {
    return state_.objects[bodyOf(part)].felt.value().spring_N_per_m;
  }

  void gather(const InTheWay& inTheWay) noexcept {
    const auto holding = state_.contact.surfaces();
    for (std::size_t k = 0; k < holding.size(); ++k) {
      const Vec3 part_m = shareOf(state_, k, penetration_m_) * normalOf(state_, holding[k]);
      const auto known = std::ranges::find(parts(), holding[k].body, [](const Part& p) { return p.held.body; });
      if (known != parts().end()) {
        known->normal += part_m;
        continue;
      }
      const SoftTissue* tissue = scene_.objects[static_cast<std::size_t>(holding[k].body)].tissue.get();
      parts_[count_++] = {.held = holding[k], .normal = part_m, .point = contact_.ihip, .tissue = tissue};
    }
    for (Part& part : parts()) {
      part.normal = part.normal != Vec3(0) ? glm::normalize(part.normal) : normalOf(state_, part.held);
      part.softness = softnessAt(scene_, state_, bodyOf(part), part.held.triangle, contact_.ihip);
    }
    if (!inTheWay.crossing) return;
    const HoldingSurface met{static_cast<int>(inTheWay.body), inTheWay.crossing.side, inTheWay.crossing.triangle};
    parts_[count_++] = {.held = met, .normal = normalOf(state_, met), .point = inTheWay.point};
  }

  /// d and y of each.
  void shareOut() noexcept {
    std::array<double, ContactState::kMaxHolding> before_m{}, left{};
    for (const BodyDent& dent : state_.allDents()) {
      const auto own =
          std::ranges::find(parts(), static_cast<int>(dent.body), [](const Part& p) { return p.held.body; });
      if (dent.pressed && own != parts().end())
        before_m[static_cast<std::size_t>(own - parts().begin())] = depth_m(dent.dent);
    }
    std::array<bool, ContactState::kMaxHolding> active{};
    std::fill_n(active.begin(), count_, true);
    glm::dmat3 products(1);
    Vec3 depth(0);
    for (std::size_t i = 0; i < count_; ++i) {
      const Part& part = parts_[i];
      const auto row = static_cast<int>(i);
      for (std::size_t j = 0; j < count_; ++j)
        products[row][static_cast<int>(j)] = glm::dot(part.normal, parts_[j].normal);
      depth[row] = glm::dot(part.normal, part.point - state_.hip);
      if (part.tissue == nullptr) continue;
      // y = q (d + y) + e before, exact for a d + y that stays.
      const double q = part.tissue->yield_m(0, 1, spring_N_per_m(part), config_.period_s, part.softness.value);
      left[i] =
          part.tissue->yield_m(before_m[i], 0, spring_N_per_m(part), config_.period_s, part.softness.value) / (1 - q);
      products[row][row] += q / (1 - q);
      depth[row] -= left[i];
    }
    for (std::size_t round = 0; round < count_; ++round) {
      const Vec3 found = solved(products, depth, active);
      std::size_t least = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        parts_[i].left_m = found[static_cast<int>(i)];
        if (parts_[i].left_m < parts_[least].left_m) least = i;
      }
      if (!(parts_[least].left_m < 0)) break;
      parts_[least].left_m = 0;
      active[least] = false;
    }
    for (std::size_t i = 0; i < count_; ++i) {
      const auto row = static_cast<int>(i);
      parts_[i].left_m = std::max(0.0, parts_[i].left_m);
      parts_[i].yield_m = (products[row][row] - 1) * parts_[i].left_m + left[i];
    }
  }

  /// 0 for what is not active. What cannot be told apart has the least of all lengths.
  [[nodiscard]] static Vec3 solved(glm::dmat3 products, Vec3 depth,
                                   const std::array<bool, ContactState::kMaxHolding>& active) noexcept {
    for (int i = 0; i < 3; ++i) {
      products[i][i] *= 1 + kRegular;
      if (active[static_cast<std::size_t>(i)]) continue;
      for (int j = 0; j < 3; ++j) products[i][j] = products[j][i] = i == j;
      depth[i] = 0;
    }
    return glm::inverse(products) * depth;
  }

  void press(const Part& part) noexcept {
    const Body& body = state_.bodies[bodyOf(part)];
    PressedBody pressed = pressedBody(part);
    Vec3 ihip = state_.hip;
    for (const Part& each : parts()) ihip += each.left_m * each.normal;
    pressed.h = body.frame.toLocal(ihip - part.left_m * part.normal);
    Yielding yielding(scene_, state_, config_, contact_.work, pressed);
    if (yielding.press()) {
      tick_.force.spring +=
          tissuePushAlong_N(scene_.objects[pressed.body], part.softness, yielding.elastic_m2(), config_);
    } else {
      for (BodyDent& dent : std::span(state_.dents).first(state_.dentCount)) {
        if (dent.body == pressed.body) dent.pressed = false;
      }
    }
  }

  [[nodiscard]] PressedBody pressedBody(const Part& part) const noexcept {
    const std::size_t index = bodyOf(part);
    Foot atRest;
    atRest.triangle = part.held.triangle;
    atRest.point = state_.bodies[index].frame.toLocal(contact_.ihip);
    return {.body = index,
            .atRest = atRest,
            .side = part.held.side,
            .below = true,
            .contact_N_per_m = spring_N_per_m(part),
            .softness = part.softness.value};
  }

  /// The IHIP: of what is on the surfaces as they are now, or outside, the nearest to the HIP.
  void settle() noexcept {
    if (state_.contact.holdingCount == 1 && isClear()) return;
    Vec3 ihip = contact_.ihip, planeParts;
    for (int round = 0; round < kRounds; ++round) {
      std::array<Plane, ContactState::kMaxHolding> planes;
      const std::size_t count = planesAt(ihip, planes);
      ihip = nearestOutside(planes, count, planeParts);
    }
    contact_.penetration_m = glm::distance(ihip, state_.hip);
    if (!(contact_.penetration_m > 0)) return lose(state_, static_cast<std::size_t>(contact_.body), contact_);
    contact_.alongNormal = false;
    contact_.ihip = ihip;
    contact_.normal = (ihip - state_.hip) / contact_.penetration_m;
    if (state_.contact.holdingCount == 1 && !(planeParts[0] > 0)) meet(parts_[1].held);
  }

  /// The dent is not as deep as what is in the way, and holds the IHIP alone.
  [[nodiscard]] bool isClear() noexcept {
    const Body& body = state_.bodies[bodyOf(parts_[0])];
    const PressedBody pressed = pressedBody(parts_[0]);
    Yielding yielding(scene_, state_, config_, contact_.work, pressed);
    const Yielding::Nearest at = yielding.nearestTo(body.frame.toLocal(state_.hip));
    const Vec3 ihip = body.frame.toWorld(at.foot.point);
    if (at.outside || glm::dot(parts_[1].normal, ihip - parts_[1].point) < 0) return false;
    contact_.alongNormal = false;
    contact_.ihip = ihip;
    contact_.normal = body.frame.turn(at.normal);
    contact_.penetration_m = glm::distance(ihip, state_.hip);
    contact_.primitive = primitiveOf(*body.surface, at.foot);
    contact_.triangle = at.foot.triangle;
    return true;
  }

  /// The dents leave the HIP outside of the body that holds the IHIP, but not of the one in the way.
  void meet(const HoldingSurface& held) noexcept {
    state_.release();
    contact_.body = held.body;
    contact_.triangle = held.triangle;
    contact_.primitive = primitiveOf(*state_.bodies[static_cast<std::size_t>(held.body)].surface, Foot{held.triangle});
  }

  [[nodiscard]] std::size_t planesAt(Vec3 ihip, std::array<Plane, ContactState::kMaxHolding>& planes) noexcept {
    std::size_t count = 0;
    for (const Part& part : parts()) {
      if (part.tissue == nullptr) {
        planes[count++] = {part.point, part.normal};
        continue;
      }
      const Body& body = state_.bodies[bodyOf(part)];
      const PressedBody pressed = pressedBody(part);
      Yielding yielding(scene_, state_, config_, contact_.work, pressed);
      const Yielding::Nearest at = yielding.nearestTo(body.frame.toLocal(ihip));
      planes[count++] = {body.frame.toWorld(at.foot.point), body.frame.turn(at.normal)};
      if (part.held.body == contact_.body) contact_.triangle = at.foot.triangle;
    }
    return count;
  }

  /// The HIP where it is outside of all planes.
  /// @param parts  What each plane has of the way there.
  [[nodiscard]] Vec3 nearestOutside(const std::array<Plane, ContactState::kMaxHolding>& planes, std::size_t count,
                                    Vec3& parts) const noexcept {
    std::array<bool, ContactState::kMaxHolding> active{};
    std::fill_n(active.begin(), count, true);
    glm::dmat3 products(1);
    Vec3 depth(0);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      for (std::size_t j = 0; j < planes.size(); ++j) {
        products[static_cast<int>(i)][static_cast<int>(j)] = glm::dot(planes[i].normal, planes[j].normal);
      }
      depth[static_cast<int>(i)] = glm::dot(planes[i].normal, planes[i].point - state_.hip);
    }
    for (std::size_t round = 0; round <= count; ++round) {
      parts = solved(products, depth, active);
      int least = 0;
      for (int i = 1; i < 3; ++i) {
        if (parts[i] < parts[least]) least = i;
      }
      if (!(parts[least] < 0)) break;
      active[static_cast<std::size_t>(least)] = false;
    }
    Vec3 out = state_.hip;
    for (std::size_t i = 0; i < planes.size(); ++i) out += parts[static_cast<int>(i)] * planes[i].normal;
    return out;
  }

  const ServoScene& scene_;
  HapticState& state_;
  const StepConfig& config_;
  FeltTick& tick_;
  ContactResult& contact_;
  Vec3 penetration_m_;
  std::array<Part, ContactState::kMaxHolding> parts_;
  std::size_t count_ = 0;
};

/// What the dent of the one body that holds the IHIP would come upon.
[[nodiscard]] InTheWay whatIsBelow(const ServoScene& scene, const HapticState& state, const StepConfig& config,
                                   const ContactResult& contact) noexcept {
  if (!(contact.penetration_m > 0)) return {};
  const auto index = static_cast<std::size_t>(contact.body);
  double yielded_m = 0;
  for (const BodyDent& dent : state.allDents()) {
    if (dent.pressed && dent.body == index) yielded_m = depth_m(dent.dent);
  }
  const double softness = softnessAt(scene, state, index, state.contact.holding[0].triangle, contact.ihip).value;
  const double yield_m = scene.objects[index].tissue->yield_m(
      yielded_m, contact.penetration_m, state.objects[index].felt.value().spring_N_per_m, config.period_s, softness);
  return firstInTheWay(state, index, contact.ihip,
                       glm::mix(contact.ihip, state.hip, std::min(1.0, yield_m / contact.penetration_m)));
}

[[gnu::noinline]] void yieldTogether(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                     FeltTick& tick, const InTheWay& inTheWay) noexcept {
  Together(scene, state, config, tick, inTheWay).run();
}

/// Whether a body has come in the way of a dent that is deeper than there: by an edit or a motion, not by the hand.
[[nodiscard]] bool hasComeBetween(const HapticState& state, const ContactResult& contact,
                                  const InTheWay& below) noexcept {
  constexpr double kByHand_m = 1e-4;
  return std::ranges::any_of(state.allDents(), [&](const BodyDent& dent) {
    return dent.pressed && dent.body == static_cast<std::size_t>(contact.body) &&
           depth_m(dent.dent) > glm::distance(contact.ihip, below.point) + kByHand_m;
  });
}

/// What of the bodies that hold the IHIP is soft yields.
void yield(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick) noexcept {
  const auto isSoft = [&](int body) { return scene.objects[static_cast<std::size_t>(body)].tissue != nullptr; };
  if (severalBodiesHold(state)) {
    const auto holding = state.contact.surfaces();
    const bool anySoft = std::ranges::any_of(holding, [&](const HoldingSurface& held) { return isSoft(held.body); });
    if (anySoft) yieldTogether(scene, state, config, tick, {});
    return;
  }
  if (!isSoft(tick.contact.body)) return;
  if (state.bodyCount > 1) {
    const InTheWay below = whatIsBelow(scene, state, config, tick.contact);
    if (below.crossing) {
      if (hasComeBetween(state, tick.contact, below)) {
        state.contactBroken = true;
        state.slew.begin();
      }
      return yieldTogether(scene, state, config, tick, below);
    }
  }
  yieldAlone(scene, state, config, tick);
}

}  // namespace

void yieldToContact(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick) noexcept {
  const ContactResult& contact = tick.contact;
  for (BodyDent& dent : std::span(state.dents).first(state.dentCount)) {
    dent.pressed = dent.pressed && contact.touching && holdsIhip(state, dent.body);
  }
  const auto before = state.dents;
  const std::size_t countBefore = state.dentCount;
  relaxDents(scene, state, config);
  if (contact.touching) yield(scene, state, config, tick);
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
