#include "haptic_server/servo/soft_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "haptic_server/contact/deformed_surface.h"

namespace haptics {
namespace {

/// Of a falloff's radius: a dent that has gone back this far is gone. Larger ends with a jump; smaller keeps places.
constexpr double kGone = 0x1p-14;
/// Where a contact finds no place for its dent, the weakest one is hurried back (seconds). Shorter can be felt; longer
/// leaves the new contact hard for longer.
constexpr double kHurried_s = 0.01;

/// The dents of one body, in the order in which they are told.
struct BodyDents {
  std::array<Dent, kMaxDents> dent;
  std::size_t count = 0;

  [[nodiscard]] std::span<const Dent> all() const noexcept { return std::span(dent).first(count); }
};

[[nodiscard]] BodyDents dentsOf(const HapticState& state, std::size_t body) noexcept {
  BodyDents dents;
  for (const BodyDent& dent : state.allDents()) {
    if (dent.body == body) dents.dent[dents.count++] = dent.dent;
  }
  return dents;
}

/// What each of the triangle's corners has of a point in it. The point is projected on to the triangle along its normal.
[[nodiscard]] Vec3 barycentric(const TriangleRecord& r, Vec3 point) noexcept {
  const Vec3 normal = r.areaNormal();
  const double area2 = squaredLength(normal);
  if (!(area2 > 0)) return Vec3(1.0 / 3);
  Vec3 share;
  for (int k = 0; k < 3; ++k) {
    const Vec3 from = r.corner(nextCorner(k));
    const Vec3 edge = r.corner(previousCorner(k)) - from;
    share[k] = std::clamp(glm::dot(glm::cross(edge, point - from), normal) / area2, 0.0, 1.0);
  }
  return share / (share.x + share.y + share.z);
}

/// One contact with a soft body, in the body's frame.
class Yielding {
 public:
  Yielding(const SoftTissue& tissue, HapticState& state, const StepConfig& config, ContactResult& contact) noexcept
      : tissue_(tissue),
        state_(state),
        config_(config),
        contact_(contact),
        index_(static_cast<std::size_t>(contact.body)),
        body_(state.bodies[index_]),
        held_(state.contact.holding[0]),
        foot_(body_.frame.toLocal(contact.ihip)),
        h_(body_.frame.toLocal(state.hip)) {}

  void run() noexcept {
    if (state_.pressing && isElsewhere()) state_.release();
    if (!state_.pressing && !findPlace()) return settle();
    const double depth = contact_.penetration_m;
    const Vec3 direction = depth > 0 ? (h_ - foot_) / depth : Vec3(0);
    Dent& pressed = state_.dents[state_.pressedDent].dent;
    pressed.centre = Vec3f(foot_);
    const Vec3 share = barycentric(body_.surface->triangle(held_.triangle), foot_);
    const double seen = falloffAt(pressed, share);  // of the dent, on this mesh
    const double others = glm::dot(displacementByOthers(share), direction);
    const double before = seen * glm::length(Vec3(pressed.displacement)) + others;
    const double yielded =
        tissue_.yield_m(before, depth, state_.objects[index_].felt.value().spring_N_per_m, config_.period_s);
    const double wanted = seen > 0 ? (yielded - others) / seen : 0;
    pressed.displacement = Vec3f(direction * std::clamp(wanted, 0.0, room()));
    settle();
  }

 private:
  /// Than the dent that the contact pressed in the last tick: a fast hand has left it and come in again.
  [[nodiscard]] bool isElsewhere() const noexcept {
    const Vec3 centre(state_.dents[state_.pressedDent].dent.centre);
    const double radius = tissue_.falloff.radius_m();
    return squaredLength(foot_ - centre) > radius * radius;
  }

  /// For a dent of this contact. When there is none, the weakest is hurried back, and the contact is hard meanwhile.
  [[nodiscard]] bool findPlace() noexcept {
    if (state_.dentCount == kMaxDents) {
      const auto weakest = std::min_element(
          state_.dents.begin(), state_.dents.end(),
          [](const BodyDent& a, const BodyDent& b) { return squaredLengthOf(a) < squaredLengthOf(b); });
      weakest->dent.displacement *= static_cast<float>(std::exp(-config_.period_s / kHurried_s));
      return false;
    }
    state_.pressedDent = state_.dentCount++;
    state_.dents[state_.pressedDent] = {index_, {}};
    state_.pressing = true;
    return true;
  }

  [[nodiscard]] static double squaredLengthOf(const BodyDent& dent) noexcept {
    return squaredLength(Vec3(dent.dent.displacement));
  }

  /// How deep this dent may be, so that all of the body's stay within deepestDent_m().
  [[nodiscard]] double room() const noexcept {
    double left = deepestDent_m(tissue_.falloff);
    for (std::size_t i = 0; i < state_.dentCount; ++i) {
      const BodyDent& other = state_.dents[i];
      if (i != state_.pressedDent && other.body == index_) left -= std::sqrt(squaredLengthOf(other));
    }
    return std::max(0.0, left);
  }

  [[nodiscard]] double falloffAt(const Dent& dent, Vec3 share) const noexcept {
    const TriangleRecord& r = body_.surface->triangle(held_.triangle);
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += share[k] * tissue_.falloff.at(r.corner(k) - Vec3(dent.centre));
    return sum;
  }

  [[nodiscard]] Vec3 displacementByOthers(Vec3 share) const noexcept {
    Vec3 sum(0);
    for (std::size_t i = 0; i < state_.dentCount; ++i) {
      const BodyDent& other = state_.dents[i];
      if (i == state_.pressedDent || other.body != index_) continue;
      sum += Vec3(other.dent.displacement) * falloffAt(other.dent, share);
    }
    return sum;
  }

  /// On the dented triangles.
  void settle() noexcept {
    const BodyDents dents = dentsOf(state_, index_);
    const auto moved = [&](Vec3f rest) noexcept { return dented(rest, dents.all(), tissue_.falloff); };
    const DeformedSurface deformed(*body_.surface, moved);
    const Foot foot = deformed.closestFrom(held_.triangle, h_, contact_.work.triangles);
    const Vec3 normal = unitOrZero(deformed.normal(foot)) * double(held_.side);
    if (glm::dot(h_ - foot.point, normal) >= 0 && contact_.penetration_m > 0) {
      const Vec3 rest = contact_.ihip;
      contact_.touching = false;
      contact_.body = -1;
      contact_.ihip = state_.hip;
      contact_.normal = Vec3(0);
      contact_.penetration_m = 0;
      contact_.primitive = {};
      state_.release();
      meetInDent(rest);
      return;
    }
    contact_.ihip = body_.frame.toWorld(foot.point);
    contact_.normal = body_.frame.turn(normal);
    contact_.penetration_m = glm::distance(contact_.ihip, state_.hip);
    contact_.primitive = primitiveOf(*body_.surface, foot);
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
      contact_.inDent = met.triangle;
    }
  }

  const SoftTissue& tissue_;
  HapticState& state_;
  const StepConfig& config_;
  ContactResult& contact_;
  std::size_t index_;
  const Body& body_;
  HoldingSurface held_;
  Vec3 foot_;  // of the surface at rest
  Vec3 h_;
};

/// Dents that nothing presses go back; those that are gone leave their places.
void relax(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < state.dentCount; ++i) {
    BodyDent dent = state.dents[i];
    const bool pressed = state.pressing && i == state.pressedDent;
    const SoftTissue& tissue = *scene.objects[dent.body].tissue;
    if (!pressed) {
      dent.dent.displacement *= static_cast<float>(tissue.leftAfter(config.period_s));
      if (glm::length(Vec3(dent.dent.displacement)) <= kGone * tissue.falloff.radius_m()) continue;
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
  if (tissue != nullptr) Yielding(*tissue, state, config, contact).run();
  const auto same = [](const BodyDent& a, const BodyDent& b) { return a.body == b.body && a.dent == b.dent; };
  if (!std::ranges::equal(std::span(before).first(countBefore), state.allDents(), same)) ++state.deformationRevision;
}

bool describeDents(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept {
  bool changed = motion.dentCount != state.dentCount;
  motion.dentCount = state.dentCount;
  for (std::size_t i = 0; i < state.dentCount; ++i) {
    const BodyDent& dent = state.dents[i];
    const ObjectDent now{state.objects[dent.body].id, dent.dent};
    changed = changed || !(now == motion.dent[i]);
    motion.dent[i] = now;
  }
  if (changed) motion.tick = tick;
  return changed;
}

}  // namespace haptics
