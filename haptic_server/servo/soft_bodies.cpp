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

/// Rounds in which bodies that yield together find how far each does: their parts of the penetration hang together where
/// their normals are not square.
constexpr int kRounds = 4;
/// Determinant of the products of their normals below which these are too close together to tell their parts apart.
constexpr double kLeastDeterminant = 1e-3;

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
  contact.ihip = glm::mix(rest, state.hip, met.crossing.time);
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
  for (BodyDent& dent : std::span(state.dents).first(state.dentCount))
    dent.pressed = dent.pressed && dent.body == index;
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
                            .shaded = true,
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

/// Bodies that hold the IHIP together, each of them in series with its own tissue: of the penetration p = sum s_i n_i the
/// tissue of body i takes y_i along n_i, and k_i (s_i - sum_j (G^-1)_ij y_j) = t_i y_i with G_ij = n_i . n_j, for then the
/// IHIP is on each surface, displaced by y_i. A rigid body takes nothing.
class Together {
 public:
  Together(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick) noexcept
      : scene_(scene),
        state_(state),
        config_(config),
        tick_(tick),
        contact_(tick.contact),
        penetration_m_(tick.contact.ihip - state.hip) {}

  /// False where the parts cannot be told apart.
  [[nodiscard]] bool run() noexcept {
    gather();
    if (std::ranges::none_of(parts(), [&](const Part& part) { return tissueOf(part) != nullptr; })) return true;
    if (!invert()) return false;
    shareOut();
    for (Part& part : parts()) {
      if (tissueOf(part) != nullptr) press(part);
    }
    settle();
    return true;
  }

 private:
  /// A body's.
  struct Part {
    HoldingSurface held;  // the first of its surfaces
    Vec3 normal{0};       // world, unit
    double share_m = 0;
    double yield_m = 0;
    double seen_m = 0;  // of the penetration, by the body alone
    FactorSample softness = {};
  };
  /// World.
  struct Plane {
    Vec3 point{0};
    Vec3 normal{0};
  };

  [[nodiscard]] std::span<Part> parts() noexcept { return std::span(parts_).first(count_); }
  [[nodiscard]] static std::size_t bodyOf(const Part& part) noexcept {
    return static_cast<std::size_t>(part.held.body);
  }
  [[nodiscard]] const SoftTissue* tissueOf(const Part& part) const noexcept {
    return scene_.objects[bodyOf(part)].tissue.get();
  }
  [[nodiscard]] double spring_N_per_m(const Part& part) const noexcept {
    return state_.objects[bodyOf(part)].felt.value().spring_N_per_m;
  }

  void gather() noexcept {
    const auto holding = state_.contact.surfaces();
    for (std::size_t k = 0; k < holding.size(); ++k) {
      const Vec3 part_m = shareOf(state_, k, penetration_m_) * normalOf(state_, holding[k]);
      const auto known = std::ranges::find(parts(), holding[k].body, [](const Part& p) { return p.held.body; });
      if (known == parts().end()) {
        parts_[count_++] = {.held = holding[k], .normal = part_m};
      } else {
        known->normal += part_m;
      }
    }
    for (Part& part : parts()) {
      part.share_m = glm::length(part.normal);
      part.normal = part.share_m > 0 ? part.normal / part.share_m : normalOf(state_, part.held);
      part.softness = softnessAt(scene_, state_, bodyOf(part), part.held.triangle, contact_.ihip);
    }
  }

  [[nodiscard]] bool invert() noexcept {
    glm::dmat3 products(1);
    for (int i = 0; i < static_cast<int>(count_); ++i) {
      for (int j = 0; j < i; ++j) {
        products[i][j] = products[j][i] =
            glm::dot(parts_[static_cast<std::size_t>(i)].normal, parts_[static_cast<std::size_t>(j)].normal);
      }
    }
    if (glm::determinant(products) < kLeastDeterminant) return false;
    inverse_ = glm::inverse(products);
    return true;
  }

  void shareOut() noexcept {
    for (const BodyDent& dent : state_.allDents()) {
      if (!dent.pressed) continue;
      const auto own =
          std::ranges::find(parts(), static_cast<int>(dent.body), [](const Part& p) { return p.held.body; });
      if (own != parts().end()) own->yield_m = depth_m(dent.dent);
    }
    const std::array<Part, ContactState::kMaxHolding> before = parts_;
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 0; i < count_; ++i) {
        Part& part = parts_[i];
        const SoftTissue* tissue = tissueOf(part);
        if (tissue == nullptr) continue;
        double left_m = part.share_m;
        for (std::size_t j = 0; j < count_; ++j) {
          if (j != i) left_m -= product(i, j) * parts_[j].yield_m;
        }
        part.seen_m = std::max(0.0, left_m / product(i, i));
        part.yield_m = tissue->yield_m(before[i].yield_m, part.seen_m, spring_N_per_m(part) * product(i, i),
                                       config_.period_s, part.softness.value);
      }
    }
  }
  [[nodiscard]] double product(std::size_t i, std::size_t j) const noexcept {
    return inverse_[static_cast<int>(i)][static_cast<int>(j)];
  }

  void press(const Part& part) noexcept {
    const std::size_t i = static_cast<std::size_t>(&part - parts_.data());
    const Body& body = state_.bodies[bodyOf(part)];
    PressedBody pressed = pressedBody(part);
    pressed.h = body.frame.toLocal(contact_.ihip - part.seen_m * part.normal);
    pressed.contact_N_per_m *= product(i, i);
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

  /// The IHIP: of what is on all of the surfaces, or outside, the nearest to the HIP.
  void settle() noexcept {
    Vec3 ihip = contact_.ihip;
    for (int round = 0; round < kRounds; ++round) {
      std::array<Plane, ContactState::kMaxHolding> planes;
      const std::size_t count = planesAt(ihip, planes);
      ihip = nearestOutside(std::span(planes).first(count));
    }
    if (ihip == state_.hip) return lose(state_, static_cast<std::size_t>(contact_.body), contact_);
    contact_.alongNormal = false;
    contact_.ihip = ihip;
    contact_.penetration_m = glm::distance(ihip, state_.hip);
    contact_.normal = (ihip - state_.hip) / contact_.penetration_m;
  }

  [[nodiscard]] std::size_t planesAt(Vec3 ihip, std::array<Plane, ContactState::kMaxHolding>& planes) noexcept {
    std::size_t count = 0;
    for (const Part& part : parts()) {
      if (tissueOf(part) == nullptr) continue;
      const Body& body = state_.bodies[bodyOf(part)];
      const PressedBody pressed = pressedBody(part);
      Yielding yielding(scene_, state_, config_, contact_.work, pressed);
      const Yielding::Nearest at = yielding.nearestTo(body.frame.toLocal(ihip));
      planes[count++] = {body.frame.toWorld(at.foot.point), body.frame.turn(at.normal)};
      if (part.held.body == contact_.body) contact_.triangle = at.foot.triangle;
    }
    for (const HoldingSurface& held : state_.contact.surfaces()) {
      if (scene_.objects[static_cast<std::size_t>(held.body)].tissue) continue;
      planes[count++] = {contact_.ihip, normalOf(state_, held)};
    }
    return count;
  }

  /// The HIP where it is outside of all planes.
  [[nodiscard]] Vec3 nearestOutside(std::span<Plane> planes) const noexcept {
    for (std::size_t count = planes.size(); count > 0; --count) {
      glm::dmat3 products(1);
      Vec3 below_m(0);
      for (int i = 0; i < static_cast<int>(count); ++i) {
        const Plane& plane = planes[static_cast<std::size_t>(i)];
        for (int j = 0; j < static_cast<int>(count); ++j) {
          products[j][i] = glm::dot(plane.normal, planes[static_cast<std::size_t>(j)].normal);
        }
        below_m[i] = glm::dot(plane.normal, plane.point - state_.hip);
      }
      const bool distinct = glm::determinant(products) >= kLeastDeterminant;
      const Vec3 parts = distinct ? glm::inverse(products) * below_m : below_m;
      std::size_t least = 0;
      for (std::size_t i = 1; i < count; ++i) {
        if (parts[static_cast<int>(i)] < parts[static_cast<int>(least)]) least = i;
      }
      if (distinct && parts[static_cast<int>(least)] >= 0) {
        Vec3 out = state_.hip;
        for (std::size_t i = 0; i < count; ++i) out += parts[static_cast<int>(i)] * planes[i].normal;
        return out;
      }
      std::swap(planes[least], planes[count - 1]);
    }
    return state_.hip;
  }

  const ServoScene& scene_;
  HapticState& state_;
  const StepConfig& config_;
  FeltTick& tick_;
  ContactResult& contact_;
  Vec3 penetration_m_;
  std::array<Part, ContactState::kMaxHolding> parts_;
  std::size_t count_ = 0;
  glm::dmat3 inverse_{1};
};

[[gnu::noinline]] bool yieldTogether(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                     FeltTick& tick) noexcept {
  return Together(scene, state, config, tick).run();
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
  if (contact.touching) {
    const bool together = severalBodiesHold(state) && yieldTogether(scene, state, config, tick);
    if (!together && scene.objects[static_cast<std::size_t>(contact.body)].tissue) {
      yieldAlone(scene, state, config, tick);
    }
  }
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
