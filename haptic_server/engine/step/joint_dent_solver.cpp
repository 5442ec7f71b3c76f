#include "haptic_server/engine/step/joint_dent_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "haptic_server/engine/contact/neighborhood_watch.h"
#include "haptic_server/engine/step/held_planes.h"
#include "haptic_server/engine/step/held_springs.h"

namespace haptics {
namespace {

/// Rounds in which the IHIP is looked for on several dented surfaces: they are not flat.
constexpr int kJointRounds = 3;
constexpr int kObstructedRounds = 2;  // of one, and of what is in its way
/// More, where the last one moved the IHIP by more than counts as on the surface.
constexpr int kMaxJointRounds = 12;
/// Of a way towards the IHIP: the least step on it, and how often the place is looked for where it meets a dented surface, by
/// the secant and then by halves.
constexpr double kMinStep = 0.125;
constexpr int kMeetings = 4, kHalvings = 12;
/// How far inside (m) counts.
constexpr double kOnSurface_m = 1e-6;
/// Rounds, at most, in which what different springs push is looked for, and of it what a round may still change.
constexpr int kSpringRounds = 40;
constexpr double kSpringChange = 1e-5;
/// Of a contact's own spring: where next to nothing is left for it, what a surface pushes over that has no end.
constexpr double kStiffest = 1e5;
/// Units (Allowance) of such a round for three bodies.
constexpr std::int64_t kSpringRound = 1'700;

/// Bodies that hold the IHIP together, each of them in series with its own tissue. With p_i the depth of the HIP below
/// surface i at rest, d_i what is left of it for the contact's spring and y_i what the tissue takes,
///   sum_j n_i . n_j d_j + y_i = p_i,  d_i >= 0,
/// for the IHIP, HIP + sum d_j n_j, is on each surface displaced by y_i; and y_i = r_i d_i + a_i, where r = k / t for an
/// elastic tissue and 0 for a rigid body (SoftTissue has the viscous one). k_i is what surface i pushes over d_i: where
/// contact springs differ, not its own (GrooveSprings), and found with d.
class JointDentSolver {
 public:
  /// @param obstruction  Of the one body that holds the IHIP, into another one; or nothing.
  JointDentSolver(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick,
                  const Obstruction& obstruction) noexcept
      : scene_(scene),
        state_(state),
        config_(config),
        tick_(tick),
        contact_(tick.contact),
        penetration_m_(tick.contact.ihip - state.estimate.hip) {
    gather(obstruction);
  }

  void run() noexcept {
    Allowance& allowance = contact_.work.allowance;
    const std::int64_t aside = allowance.left() / 4 * 3;
    for (int round = 0; round < kSpringRounds; ++round) {
      shareOut();
      if (!springsDiffer()) break;
      allowance.spend(kSpringRound);
      if (allowance.left() < aside) {
        state_.fallBehind(contact_.work);
        break;
      }
      if (!followSprings()) break;
    }
    for (Part& part : parts()) {
      if (part.tissue != nullptr) press(part);
    }
    settle();
  }

 private:
  /// A body that holds the IHIP; world.
  struct Part {
    ContactSurface held;                 // the first of its surfaces
    Vec3 normal{0};                      // unit
    Vec3 point{0};                       // on its plane at rest
    const SoftTissue* tissue = nullptr;  // null: rigid
    FactorSample softness = {};
    double spring_N_per_m = 0;  // k
    double left_m = 0;          // d
    double yield_m = 0;         // y
  };
  [[nodiscard]] std::span<Part> parts() noexcept { return std::span(parts_).first(count_); }
  [[nodiscard]] static std::size_t bodyOf(const Part& part) noexcept {
    return static_cast<std::size_t>(part.held.body);
  }
  [[nodiscard]] double ownSpring_N_per_m(const Part& part) const noexcept {
    return state_.objects[bodyOf(part)].stiffness.value().spring_N_per_m;
  }
  /// What is in the way does not hold the IHIP: it has no spring of its own.
  [[nodiscard]] bool springsDiffer() noexcept {
    const auto differs = [&](const Part& p) { return ownSpring_N_per_m(p) != ownSpring_N_per_m(parts_[0]); };
    return !obstructed_ && std::ranges::any_of(parts(), differs);
  }

  void gather(const Obstruction& obstruction) noexcept {
    const auto holding = state_.contact.surfaces();
    for (std::size_t k = 0; k < holding.size(); ++k) {
      const Vec3 part_m = partOf(state_, k, penetration_m_) * normalOf(state_, holding[k]);
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
      part.spring_N_per_m = ownSpring_N_per_m(part);
      part.softness = softnessAt(scene_, state_, bodyOf(part), part.held.triangle, contact_.ihip);
    }
    obstructed_ = static_cast<bool>(obstruction.crossing);
    if (!obstructed_) return;
    const ContactSurface met{static_cast<int>(obstruction.body), obstruction.crossing.side,
                             obstruction.crossing.triangle};
    parts_[count_++] = {.held = met, .normal = normalOf(state_, met), .point = obstruction.point};
  }

  /// d and y of each.
  void shareOut() noexcept {
    std::array<double, ContactState::kMaxHolding> left{};
    glm::dmat3 products(1);
    Vec3 depth(0);
    for (std::size_t i = 0; i < count_; ++i) {
      const Part& part = parts_[i];
      const auto row = static_cast<int>(i);
      for (std::size_t j = 0; j < count_; ++j)
        products[row][static_cast<int>(j)] = glm::dot(part.normal, parts_[j].normal);
      depth[row] = glm::dot(part.normal, part.point - state_.estimate.hip);
      if (part.tissue == nullptr) continue;
      // y = q (d + y) + e before, exact for a d + y that stays.
      const double q = part.tissue->yield_m(0, 1, part.spring_N_per_m, config_.period_s, part.softness.value);
      const double before_m = pressedDepth_m(state_, bodyOf(part));
      left[i] = part.tissue->yield_m(before_m, 0, part.spring_N_per_m, config_.period_s, part.softness.value) / (1 - q);
      products[row][row] += q / (1 - q);
      depth[row] -= left[i];
    }
    const Vec3 found = notNegative(products, depth, count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const auto row = static_cast<int>(i);
      parts_[i].left_m = found[row];
      parts_[i].yield_m = (products[row][row] - 1) * parts_[i].left_m + left[i];
    }
  }

  /// k of each, from d. False where that has not changed.
  [[nodiscard]] bool followSprings() noexcept {
    GrooveSprings springs;
    Vec3 left_m(0);
    for (const Part& part : parts()) {
      springs.add(part.normal, ownSpring_N_per_m(part));
      left_m += part.left_m * part.normal;
    }
    const Vec3 force_N = springs.force_N(left_m);
    bool changed = false;
    for (std::size_t i = 0; i < count_; ++i) {
      Part& part = parts_[i];
      if (!(part.left_m > 0)) continue;
      const Vec3 third = count_ > 2 ? parts_[(i + 2) % count_].normal : Vec3(0);
      const double held_N = std::max(0.0, heldPart(force_N, part.normal, parts_[(i + 1) % count_].normal, third));
      const double now = std::min(held_N / part.left_m, kStiffest * ownSpring_N_per_m(part));
      changed = changed || std::abs(now - part.spring_N_per_m) > kSpringChange * part.spring_N_per_m;
      part.spring_N_per_m = now;
    }
    return changed;
  }

  void press(const Part& part) noexcept {
    const Body& body = state_.bodies[bodyOf(part)];
    PressedBody pressed = pressedBody(part);
    Vec3 ihip = state_.estimate.hip;
    for (const Part& each : parts()) ihip += each.left_m * each.normal;
    pressed.h = body.frame.toLocal(ihip - part.left_m * part.normal);
    DentSolver yielding(scene_, state_, config_, contact_.work, pressed);
    if (yielding.press()) {
      tick_.force.spring +=
          tissuePushAlong_N(scene_.objects[pressed.body], part.softness, yielding.elastic_m2(), config_);
    } else {
      for (BodyDent& dent : state_.dents.all()) {
        if (dent.body == pressed.body) dent.pressed = false;
      }
    }
  }

  [[nodiscard]] PressedBody pressedBody(const Part& part) const noexcept {
    const std::size_t index = bodyOf(part);
    ClosestPoint atRest;
    atRest.triangle = part.held.triangle;
    atRest.point = state_.bodies[index].frame.toLocal(contact_.ihip);
    return {.body = index,
            .atRest = atRest,
            .side = part.held.side,
            .below = true,
            .contact_N_per_m = part.spring_N_per_m,
            .softness = part.softness.value};
  }

  /// The IHIP: of what is on the surfaces as they are now, or outside, the nearest to the HIP that it slides to from where
  /// it is on the shapes at rest.
  void settle() noexcept {
    if (obstructed_ && isClear()) return;
    Vec3 planeParts;
    putFeetAtRest();
    const Vec3 begin = liftedOut(contact_.ihip);  // a dent that goes along its surface lifts some of it
    Vec3 ihip = begin;
    const auto nearestOnPlanes = [&](Vec3 from) noexcept {
      return planesAt(from).nearestOutside(state_.estimate.hip, planeParts);
    };
    if (obstructed_) {
      ihip = inRounds(kObstructedRounds, ihip, nearestOnPlanes);
      if (!(planeParts[0] > 0)) ihip = followObstruction();
      putFeetAtRest();
      ihip = clearOfDents(begin, ihip);
    } else {
      ihip =
          inRounds(kJointRounds, ihip, [&](Vec3 from) noexcept { return clearOfDents(from, nearestOnPlanes(from)); });
    }
    ihip = liftedOut(ihip);  // from where the surfaces are nearer than those from which the way began
    contact_.penetration_m = glm::distance(ihip, state_.estimate.hip);
    if (!(contact_.penetration_m > 0)) {
      Obstruction met = firstObstruction(state_, static_cast<std::size_t>(contact_.body), contact_.ihip,
                                         state_.estimate.hip, contact_.work.allowance);
      if (!met.crossing) return lose(state_, contact_);
      putFeetAtRest();
      met.point = clearOfDents(begin, met.point);
      return loseTo(met, state_, contact_);
    }
    contact_.alongNormal = false;
    contact_.ihip = ihip;
    contact_.normal = (ihip - state_.estimate.hip) / contact_.penetration_m;
    if (obstructed_ && !(planeParts[0] > 0)) meet(parts_[1].held);
  }

  /// The place nearest to the HIP around what is in the way, which alone holds the IHIP and is no plane.
  [[nodiscard]] Vec3 followObstruction() noexcept {
    Part& met = parts_[1];
    const Body& body = state_.bodies[bodyOf(met)];
    Allowance& allowance = contact_.work.allowance;
    SearchRun run{.budget = searchBudget(allowance)};
    const Vec3 hip = body.frame.toLocal(state_.estimate.hip);
    const ClosestPoint foot = neighborhoodWatch(*body.surface, met.held.triangle, hip, run).foot;
    allowance.spend(Allowance::kNearTriangle * run.looked);
    met.held.triangle = foot.triangle;
    return body.frame.toWorld(foot.point);
  }

  /// At least so many rounds, and more while they move it: half of the way where that goes to and fro.
  template <class Round>
  [[nodiscard]] Vec3 inRounds(int rounds, Vec3 at, const Round& next) noexcept {
    double moved_m = std::numeric_limits<double>::infinity();
    for (int round = 0; round < rounds || (round < kMaxJointRounds && moved_m > kOnSurface_m); ++round) {
      const Vec3 from = at, to = next(from);
      const double way_m = glm::distance(from, to);
      at = round >= rounds && way_m > moved_m / 2 ? glm::mix(from, to, 0.5) : to;
      moved_m = way_m;
    }
    return at;
  }

  void putFeetAtRest() noexcept {
    std::ranges::transform(parts(), foot_.begin(), [](const Part& part) { return part.held.triangle; });
  }

  /// Out of the dented surfaces, plane by plane as they are near the place.
  [[nodiscard]] Vec3 liftedOut(Vec3 place) noexcept {
    Vec3 parts;
    for (int round = 0; round < kMaxJointRounds && clearance_m(place) < -kOnSurface_m; ++round)
      place = planesAt(place).nearestOutside(place, parts);
    return place;
  }

  /// As far of a way as is outside of the dented surfaces, which are not flat: their planes may leave its end inside.
  /// @param from  Outside.
  [[nodiscard]] Vec3 clearOfDents(Vec3 from, Vec3 to) noexcept {
    const double way_m = glm::distance(from, to);
    if (!(way_m > kOnSurface_m)) return from;
    const auto at = [&](double gone) noexcept { return glm::mix(from, to, gone); };
    double clear = 0, clear_m = clearance_m(from);
    while (clear < 1) {
      const double next = std::min(1.0, clear + std::max(clear_m / way_m, kMinStep));
      const double next_m = clearance_m(at(next));
      if (next_m < -kOnSurface_m) return at(meeting(at, {clear, clear_m}, {next, next_m}));
      clear = next;
      clear_m = next_m;
    }
    return to;
  }

  struct OnWay {
    double gone;
    double clearance_m;
  };
  /// Where a way comes upon the dented surfaces.
  template <class At>
  [[nodiscard]] double meeting(const At& at, OnWay outside, OnWay inside) noexcept {
    for (int i = 0; i < kMeetings + kHalvings && outside.clearance_m > kOnSurface_m; ++i) {
      const double part = i < kMeetings ? outside.clearance_m / (outside.clearance_m - inside.clearance_m) : 0.5;
      const double gone = glm::mix(outside.gone, inside.gone, part);
      const OnWay between{gone, clearance_m(at(gone))};
      (between.clearance_m < -kOnSurface_m ? inside : outside) = between;
    }
    return outside.gone;
  }

  /// Of the dented surfaces; negative inside of one.
  [[nodiscard]] double clearance_m(Vec3 place) noexcept {
    double least_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count_; ++i) {
      if (parts_[i].tissue == nullptr) continue;
      const DentSolver::Nearest at = nearestOn(i, place);
      const Vec3 local = state_.bodies[bodyOf(parts_[i])].frame.toLocal(place);
      least_m = std::min(least_m, glm::dot(local - at.foot.point, at.normal));
    }
    return least_m;
  }

  /// On a dented surface, from where it was nearest before: beyond a rim the nearest place is another one.
  [[nodiscard]] DentSolver::Nearest nearestOn(std::size_t part, Vec3 place) noexcept {
    PressedBody pressed = pressedBody(parts_[part]);
    pressed.atRest.triangle = foot_[part];
    DentSolver yielding(scene_, state_, config_, contact_.work, pressed);
    const DentSolver::Nearest at = yielding.nearestTo(state_.bodies[pressed.body].frame.toLocal(place));
    foot_[part] = at.foot.triangle;
    return at;
  }

  /// The dent is not as deep as what is in the way, and holds the IHIP alone.
  [[nodiscard]] bool isClear() noexcept {
    const Body& body = state_.bodies[bodyOf(parts_[0])];
    const PressedBody pressed = pressedBody(parts_[0]);
    DentSolver yielding(scene_, state_, config_, contact_.work, pressed);
    const DentSolver::Nearest at = yielding.nearestTo(body.frame.toLocal(state_.estimate.hip));
    const Vec3 beyond_m = body.frame.toWorld(at.foot.point) - parts_[1].point;
    if (at.outside || glm::dot(parts_[1].normal, beyond_m) < 0) return false;
    settleOn(state_, bodyOf(parts_[0]), at, contact_);
    return true;
  }

  /// The dents leave the HIP outside of the body that holds the IHIP, but not of the one in the way.
  void meet(const ContactSurface& held) noexcept {
    state_.release();
    contact_.body = held.body;
    contact_.triangle = held.triangle;
    contact_.primitive =
        primitiveOf(*state_.bodies[static_cast<std::size_t>(held.body)].surface, ClosestPoint{held.triangle});
  }

  [[nodiscard]] HeldPlanes planesAt(Vec3 ihip) noexcept {
    HeldPlanes planes;
    for (std::size_t i = 0; i < count_; ++i) {
      const Part& part = parts_[i];
      if (part.tissue == nullptr) {
        planes.add(part.point, part.normal);
        continue;
      }
      const Frame& frame = state_.bodies[bodyOf(part)].frame;
      const DentSolver::Nearest at = nearestOn(i, ihip);
      planes.add(frame.toWorld(at.foot.point), frame.rotate(at.normal));
      if (part.held.body == contact_.body) contact_.triangle = at.foot.triangle;
    }
    return planes;
  }

  const ServoScene& scene_;
  HapticState& state_;
  const StepConfig& config_;
  ForceResult& tick_;
  ContactResult& contact_;
  Vec3 penetration_m_;
  std::array<Part, ContactState::kMaxHolding> parts_;
  std::array<std::uint32_t, ContactState::kMaxHolding> foot_{};  // of each: the triangle last found nearest
  std::size_t count_ = 0;
  bool obstructed_ = false;  // one body holds the IHIP, part 0; part 1 is what is in its way
};

}  // namespace

void deformTogether(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick,
                    const Obstruction& obstruction) noexcept {
  JointDentSolver(scene, state, config, tick, obstruction).run();
}

}  // namespace haptics
