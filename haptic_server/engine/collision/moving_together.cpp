#include "haptic_server/engine/collision/moving_together.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "haptic_server/engine/collision/contact_solver.h"
#include "haptic_server/engine/contact/frame.h"
#include "haptic_server/engine/motion/rigid_motion.h"

namespace haptics {
namespace {

/// Rounds of a step, times the contacts, at most; with the spring and without it. More lets stacks stand stiffer and takes what
/// little speed is left of what was pushed apart, and takes longer.
constexpr int kContactRounds = 400;
struct Rounds {
  int fewest, most;
};
constexpr Rounds kSoftRounds{8, 24}, kRelaxRounds{4, 60};
/// Rounds end when they change the impulses by less than this part.
constexpr double kSettled = 2e-4;
/// Steps of a tick, at least and at most; a body bears so many times its own weight at one place before there are twice as
/// many. Twice as many let it sink a quarter as deep.
constexpr int kSteps = 2, kMaxSteps = 16;
constexpr double kWeights = 25, kGravity_m_per_s2 = 9.81;
/// A load counts as what it was until it is less than this part of it: a number of steps that came and went would shake a stack.
constexpr double kHeld = 0.5;
// Units (Allowance).
constexpr std::int64_t kContactRound = 80;  ///< A round, of a contact;
constexpr std::int64_t kContact = 200;      ///< all else that a contact costs.
/// A round with the spring and one without it in each step.
[[nodiscard]] constexpr std::int64_t leastOfContact(int steps) noexcept { return kContact + 2 * steps * kContactRound; }
/// Nearer than that bodies touch, m: they sleep and wake together.
constexpr double kTouching_m = 2e-5;
/// Deeper than kTouching_m bodies are pushed apart. Where none bears so many of its weights, the push is all that they feel.
constexpr double kBorne = 1;
/// Where they are deeper than kTouching_m, or a tick has more steps than kSteps, contacts add nothing to what they have of kinetic
/// energy: what too few rounds leave would throw them about. Deeper than this they have been put, m.
constexpr double kPut_m = 3e-4;

/// Where a pair's contact is now: its plane goes along with one body, its point with the other. World.
struct Place {
  Vec3 place{0}, normal{0};
  double gap_m = 0;
};
[[nodiscard]] Place nowAt(const BodyContact& contact, const Pose& pointsBody, const Pose& surfacesBody) noexcept {
  const Vec3 point = toWorld(pointsBody, contact.place);
  const Vec3 foot = toWorld(surfacesBody, contact.foot);
  const Vec3 normal = surfacesBody.rotation * contact.normal;
  const double gap = glm::dot(normal, point - foot);
  return {point - (0.5 * gap) * normal, normal, gap};
}

/// Bodies that touch, directly or through others.
class Islands {
 public:
  explicit Islands(std::size_t bodies) noexcept {
    for (std::size_t i = 0; i < bodies; ++i) root_[i] = static_cast<std::uint16_t>(i);
  }
  [[nodiscard]] std::uint16_t of(std::uint16_t body) noexcept {
    while (root_[body] != body) body = root_[body] = root_[root_[body]];
    return body;
  }
  void join(std::uint16_t a, std::uint16_t b) noexcept {
    a = of(a), b = of(b);
    root_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::array<std::uint16_t, kMaxColliders> root_;
};

[[nodiscard]] Vec3 velocityAt(const Collider& body, Vec3 place) noexcept {
  if (body.isDriven) return body.velocityBefore(place);
  if (!isAwake(body)) return Vec3(0);
  const RigidVelocity v = velocityOf(*body.rigidBody, *body.state);
  return v.linear + glm::cross(v.angular, place - toWorld(body.pose, body.rigidBody->mass.centre));
}

/// Now, or within this tick and the next at the speeds that they have.
[[nodiscard]] bool isTouching(const BodyPair& pair, std::span<const Collider> bodies, double period_s) noexcept {
  const Collider &first = bodies[pair.first], &second = bodies[pair.second];
  return std::ranges::any_of(pair.contacts.all(), [&](const BodyContact& contact) {
    if (contact.impulse_Ns != Vec3(0)) return true;
    const Collider &on = contact.second != 0 ? second : first, &under = contact.second != 0 ? first : second;
    const Place at = nowAt(contact, on.pose, under.pose);
    const double opening = glm::dot(velocityAt(on, at.place) - velocityAt(under, at.place), at.normal);
    return at.gap_m + 2 * period_s * std::min(opening, 0.0) < kTouching_m;  // impulses look a tick ahead of the move
  });
}

/// Those that move, by what touches.
[[nodiscard]] Islands islandsOf(std::span<const Collider> bodies, const BodyPairs& pairs, double period_s) noexcept {
  Islands islands(bodies.size());
  for (const BodyPair& pair : pairs.all()) {
    const bool bothMove = pair.used != 0 && bodies[pair.second].state != nullptr;
    if (bothMove && isTouching(pair, bodies, period_s)) islands.join(pair.first, pair.second);
  }
  return islands;
}

/// What is pushed wakes, and so does what touches a body that is awake or driven.
void wake(std::span<Collider> bodies, const BodyPairs& pairs, double period_s) noexcept {
  const auto rouse = [](RigidState& state) {
    state.condition = BodyCondition::kAwake;
    state.still_s = 0;
  };
  bool any = false, all = true;
  for (Collider& body : bodies) {
    if (body.state == nullptr) continue;
    if (body.state->condition == BodyCondition::kAsleep && body.push.any()) rouse(*body.state);
  }
  for (const BodyPair& pair : pairs.all()) {
    if (pair.used == 0 || !bodies[pair.second].isDriven) continue;
    RigidState* const state = bodies[pair.first].state;
    if (state != nullptr && state->condition == BodyCondition::kAsleep && isTouching(pair, bodies, period_s))
      rouse(*state);
  }
  for (const Collider& body : bodies) {
    any = any || isAwake(body);
    all = all && (body.state == nullptr || body.state->condition != BodyCondition::kAsleep);
  }
  if (!any || all) return;
  Islands islands = islandsOf(bodies, pairs, period_s);
  std::array<bool, kMaxColliders> awake{};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (isAwake(bodies[i])) awake[islands.of(static_cast<std::uint16_t>(i))] = true;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].state == nullptr || bodies[i].state->condition != BodyCondition::kAsleep) continue;
    if (awake[islands.of(static_cast<std::uint16_t>(i))]) rouse(*bodies[i].state);
  }
}

void sleep(std::span<Collider> bodies, const BodyPairs& pairs, double period_s) noexcept {
  std::array<bool, kMaxColliders> still{};
  bool any = false;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!isAwake(bodies[i])) continue;
    still[i] = isStill(*bodies[i].rigidBody, *bodies[i].state, bodies[i].push, period_s);
    any = any || still[i];
  }
  if (!any) return;
  Islands islands = islandsOf(bodies, pairs, period_s);
  std::array<bool, kMaxColliders> restless{};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (isAwake(bodies[i]) && !still[i]) restless[islands.of(static_cast<std::uint16_t>(i))] = true;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (still[i] && !restless[islands.of(static_cast<std::uint16_t>(i))])
      stop(*bodies[i].state, BodyCondition::kAsleep);
  }
}

/// Of a body that is awake, at the tick's start.
struct Before {
  RigidPlace place;
  Momenta momenta;

  void restoreMomentum(RigidState& state) const noexcept {
    state.momentum_Ns = momenta.momentum_Ns;
    state.angularMomentum_Nms = momenta.angularMomentum_Nms;
    state.rate_per_s = momenta.rate_per_s;
  }
};

/// The mover of what stands still.
constexpr std::uint16_t kGround = 0;

[[nodiscard]] TickSteps stepsOf(double weights, double period_s) noexcept {
  int count = kSteps;
  for (double borne = kWeights; borne < weights && count < kMaxSteps; borne *= 4) count *= 2;
  return {count, period_s / count};
}

/// One tick's constraints, and where their impulses are kept.
class Contacts {
 public:
  Contacts(std::span<Collider> bodies, std::span<const Before> before, BodyPairs& pairs,
           const TickSteps& steps) noexcept
      : bodies_(bodies), pairs_(pairs), steps_(steps), solver_(movers_, steps) {
    movers_[kGround] = Mover();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const bool isDriven = bodies[i].isDriven;
      if ((!isDriven && !isAwake(bodies[i])) || moverCount_ == movers_.size()) continue;
      mover_[i] = moverCount_++;
      movers_[mover_[i]] = isDriven ? Mover(bodies[i].pivot(), bodies[i].before)
                                    : Mover(*bodies[i].rigidBody, *bodies[i].state, before[i].momenta, steps);
    }
  }

  void add(Allowance& allowance) noexcept {
    for (std::size_t p = 0; p < pairs_.places.count; ++p) addPair(p);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (isAwake(bodies_[i]) && bodies_[i].rigidBody->freedom == Freedom::kFree) addPlanes(i, allowance);
    }
    allowance.spend(leastOfContact(steps_.count) * static_cast<std::int64_t>(solver_.size()));
  }

  /// Bodies without contacts move by a whole tick.
  void move(Allowance& rounds) noexcept {
    const auto contacts = static_cast<int>(solver_.size());
    std::array<bool, kMaxMovingBodies + 1> met{};
    double deepest_m = 0;
    for (std::uint32_t i = 0; i < solver_.size(); ++i) {
      const ContactConstraint& contact = solver_.contact(i);
      met[contact.a] = met[contact.b] = true;
      deepest_m = std::max(deepest_m, -contact.gap_m);
    }
    const bool isPushed = deepest_m > kTouching_m && pairs_.heaviestLoad < kBorne;
    const bool isBounded = (deepest_m > kTouching_m || steps_.count > kSteps) && deepest_m < kPut_m &&
                           std::ranges::none_of(bodies_, &Collider::isDriven);
    const auto energy_J = [&] {
      double sum_J = 0;
      for (std::uint16_t m = 0; m < moverCount_; ++m) sum_J += met[m] ? movers_[m].energy_J() : 0;
      return sum_J;
    };
    for (int step = 0; step < steps_.count && contacts > 0; ++step) {
      for (std::uint16_t m = 0; m < moverCount_; ++m) movers_[m].drive();
      const double most_J = isBounded ? energy_J() : 0;
      solver_.warmStart();
      solve(true, 2 * (steps_.count - step), rounds);
      for (std::uint16_t m = 0; m < moverCount_; ++m) movers_[m].move();
      solver_.moved();
      if (isPushed) solver_.takeBackPush();
      solve(false, 2 * (steps_.count - step) - 1, rounds);
      if (!isBounded) continue;
      if (const double now_J = energy_J(); now_J > most_J) {
        const double part = std::sqrt(most_J / now_J);
        for (std::uint16_t m = 0; m < moverCount_; ++m) {
          if (met[m]) movers_[m].slow(part);
        }
      }
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (!isAwake(bodies_[i])) continue;
      if (mover_[i] != kGround && met[mover_[i]]) {
        movers_[mover_[i]].give();
      } else {
        advanceRigidBody(*bodies_[i].rigidBody, *bodies_[i].state, steps_.period_s());
      }
    }
  }

  void keep() noexcept {
    std::uint32_t next = 0;  // rolling constraints are in the order of what they belong to
    const auto turningOf = [&](std::uint32_t begin, std::uint32_t end) {
      const bool has = next < solver_.rollingSize() && end > begin && solver_.rolling(next).begin == begin;
      return has ? stepCount() * solver_.rolling(next++).turning_Nms : Vec3(0);
    };
    const double load = heaviestLoad();
    if (load > pairs_.heaviestLoad || load < kHeld * pairs_.heaviestLoad) pairs_.heaviestLoad = load;
    solver_.guess();
    for (std::size_t p = 0; p < pairs_.places.count; ++p) {
      if (!isSolved(p)) continue;
      BodyPair& pair = pairs_.places[p];
      for (std::uint32_t k = 0; k < pair.contacts.count; ++k)
        pair.contacts[k].impulse_Ns = begin_[p] + k < end_[p] ? impulseOf(begin_[p] + k) : Vec3(0);
      pair.rolling_Nms = turningOf(begin_[p], end_[p]);
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (!isAwake(bodies_[i])) continue;
      RigidState& state = *bodies_[i].state;
      state.touching.count = planesEnd_[i] - planesBegin_[i];
      for (std::size_t k = 0; k < state.touching.count; ++k)
        state.touching[k].impulse_Ns = impulseOf(planesBegin_[i] + static_cast<std::uint32_t>(k));
      state.rolling_Nms = turningOf(planesBegin_[i], planesEnd_[i]);
    }
  }

 private:
  std::span<Collider> bodies_;
  BodyPairs& pairs_;
  std::array<Mover, kMaxMovingBodies + 1> movers_;
  std::uint16_t moverCount_ = 1;
  std::array<std::uint16_t, kMaxColliders> mover_{};
  std::array<std::uint32_t, kMaxPairs> begin_, end_;
  std::array<std::uint32_t, kMaxColliders> planesBegin_{}, planesEnd_{};
  TickSteps steps_;
  ContactSolver solver_;

  /// @param parts  One of so many equal parts of the allowance is for it.
  void solve(bool soft, int parts, Allowance& allowance) noexcept {
    const std::int64_t ofOthers = allowance.left() - allowance.left() / parts;
    const auto contacts = static_cast<int>(solver_.size());
    const Rounds rounds = soft ? kSoftRounds : kRelaxRounds;
    const int most = std::clamp(kContactRounds / contacts, rounds.fewest, rounds.most);
    solver_.beginRounds();
    for (int round = 0; round < most; ++round) {
      if (round > 0) {
        if (allowance.left() < ofOthers) return;
        allowance.spend(kContactRound * contacts);
        solver_.accelerate();
      }
      if (solver_.solve(soft) <= kSettled) return;
    }
  }

  [[nodiscard]] double stepCount() const noexcept { return steps_.count; }
  /// Of the tick, as the step had it.
  [[nodiscard]] Vec3 impulseOf(std::uint32_t contact) const noexcept {
    return stepCount() * solver_.contact(contact).impulse();
  }

  /// What a body bore at one place, at most, in its own weights.
  [[nodiscard]] double heaviestLoad() const noexcept {
    double weights = 0;
    for (std::size_t p = 0; p < pairs_.places.count; ++p) {
      if (!isSolved(p)) continue;
      double heaviest_Ns = 0, lightest_kg = std::numeric_limits<double>::infinity();
      for (std::uint32_t i = begin_[p]; i < end_[p]; ++i)
        heaviest_Ns = std::max(heaviest_Ns, glm::length(impulseOf(i)));
      for (const std::uint16_t body : {pairs_.places[p].first, pairs_.places[p].second}) {
        if (isAwake(bodies_[body])) lightest_kg = std::min(lightest_kg, bodies_[body].rigidBody->mass.mass_kg);
      }
      weights = std::max(weights, heaviest_Ns / (lightest_kg * kGravity_m_per_s2 * steps_.period_s()));
    }
    return weights;
  }

  [[nodiscard]] bool isSolved(std::size_t p) const noexcept {
    const BodyPair& pair = pairs_.places[p];
    return pair.used != 0 && (isAwake(bodies_[pair.first]) || isAwake(bodies_[pair.second]));
  }

  void addPair(std::size_t p) noexcept {
    begin_[p] = solver_.size();
    if (isSolved(p)) {
      const BodyPair& pair = pairs_.places[p];
      const Collider &first = bodies_[pair.first], &second = bodies_[pair.second];
      const double friction = std::sqrt(first.points->friction * second.points->friction);
      const double rolling = (first.points->rolling_m + second.points->rolling_m) / 2;
      for (const BodyContact& contact : pair.contacts.all()) {
        const bool swapped = contact.second != 0;
        const Collider &on = swapped ? second : first, &under = swapped ? first : second;
        const Place at = nowAt(contact, on.pose, under.pose);
        const double sign = swapped ? -1 : 1;  // a is the pair's first body
        if (!solver_.add(mover_[pair.first], mover_[pair.second], at.place, sign * at.normal, at.gap_m, friction,
                         rolling, contact.impulse_Ns / stepCount()))
          break;
      }
      if (solver_.size() > begin_[p]) solver_.addRolling(begin_[p], pair.rolling_Nms / stepCount());
    }
    end_[p] = solver_.size();
  }

  void addPlanes(std::size_t i, Allowance& allowance) noexcept {
    const RigidBody& body = *bodies_[i].rigidBody;
    RigidState& state = *bodies_[i].state;
    NearPlanes near;
    const std::size_t count = findNearPlanes(body, state, steps_.period_s(), near, allowance);
    planesBegin_[i] = solver_.size();
    for (std::size_t k = 0; k < count; ++k) {
      const Plane& plane = body.planes[near[k].plane];
      if (!solver_.add(mover_[i], kGround, state.centre_m + near[k].arm_m, plane.normal, near[k].gap_m, plane.friction,
                       plane.rolling_m, near[k].last_Ns / stepCount()))
        break;
      state.touching[k].plane = near[k].plane;
      state.touching[k].point = near[k].point;
    }
    if (solver_.size() > planesBegin_[i]) solver_.addRolling(planesBegin_[i], state.rolling_Nms / stepCount());
    planesEnd_[i] = solver_.size();
  }
};

}  // namespace

std::int64_t leastCollisionUnits(const BodyPairs& pairs) noexcept {
  std::int64_t contacts = 0;
  for (const BodyPair& pair : pairs.all()) contacts += static_cast<std::int64_t>(pair.used * pair.contacts.count);
  return leastOfContact(kSteps) * contacts;
}

bool moveTogether(std::span<Collider> bodies, BodyPairs& pairs, double period_s,
                  CollisionAllowance& allowance) noexcept {
  wake(bodies, pairs, period_s);
  if (std::ranges::none_of(bodies, [](const Collider& body) { return isAwake(body) || body.isDriven; })) return true;
  std::array<Before, kMaxColliders> before;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const RigidState* state = bodies[i].state;
    if (state == nullptr) continue;
    before[i] = {placeOf(*state), {state->momentum_Ns, state->angularMomentum_Nms, state->rate_per_s}};
    if (!isAwake(bodies[i])) continue;
    bodies[i].before = velocityOf(*bodies[i].rigidBody, *state);
    driveRigidBody(*bodies[i].rigidBody, *bodies[i].state, bodies[i].push, period_s);
  }
  const std::int64_t half = allowance.search.left() / 2;
  const FoundContacts found = findBodyContacts(bodies, pairs, period_s, allowance.search);
  const std::int64_t forContacts = std::min(half, leastCollisionUnits(pairs));
  const std::int64_t beyond = forContacts - std::max<std::int64_t>(allowance.motion.least.left(), 0);
  const bool fits = pairs.isFound || allowance.search.left() >= beyond;
  pairs.isFound = found.areAll && !fits;
  if (!found.areAll || !fits) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (isAwake(bodies[i])) before[i].restoreMomentum(*bodies[i].state);
    }
    return false;
  }
  Allowance ahead(std::max<std::int64_t>(allowance.search.left() - forContacts, 0));
  searchAhead(bodies, pairs, period_s, ahead);
  wake(bodies, pairs, period_s);  // what is met in this tick: a body that sleeps would be a wall
  const double load = pairs.heaviestLoad;
  Contacts contacts(bodies, before, pairs, stepsOf(load, period_s));
  contacts.add(allowance.motion.least);
  Allowance rounds(std::max(allowance.motion.rounds.left(), ahead.left()));
  contacts.move(rounds);
  contacts.keep();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (isAwake(bodies[i])) static_cast<void>(keepInWorld(*bodies[i].rigidBody, *bodies[i].state, before[i].place));
  }
  sleep(bodies, pairs, period_s);
  return found.areAllPairs;
}

}  // namespace haptics
