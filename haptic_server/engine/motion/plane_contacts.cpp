#include "haptic_server/engine/motion/plane_contacts.h"

#include <algorithm>
#include <span>

#include "common/maths/elementary.h"
#include "common/maths/sse.h"
#include "haptic_server/engine/motion/support_points.h"

namespace haptics {
namespace {

/// Most rounds over all points in a tick. Fewer leave a body that has just touched sinking for some ticks, and being lifted
/// for that, by enough to keep a faceted round body rocking.
constexpr int kRounds = 40;
/// However many bodies there are. One would let a body at rest creep.
constexpr int kMinRounds = 2;
// Units (Allowance).
constexpr std::int64_t kPoint = 3;                            ///< To see whether a support point is by a plane;
constexpr std::int64_t kPointByPlane = 5;                     ///< what one that is costs besides,
constexpr std::int64_t kCandidate = 10;                       ///< and what one that may be chosen does.
constexpr std::int64_t kRound = 64;                           ///< A round, of a point that bears the body;
constexpr std::int64_t kBearing = 112 + kMinRounds * kRound;  ///< all that such a point costs with the least rounds.
/// The rounds end when they change the impulses by less than this part. At rest the first guess is right: two do.
constexpr double kSettled = 1e-7;
/// Depth that is left alone, of the body's radius. 0 would lift bodies for ever, as rounding lets them sink.
constexpr double kSlop = 1e-4;
/// Points nearer to a plane than that, of the body's radius, count as on it even when the body stands still. 0 would let
/// a body rock between points that take turns in bearing it.
constexpr double kNear = 1e-3;
/// Beside the deepest point so many are enough to choose from while a body is fast: where it lands is known once it is near.
constexpr std::size_t kFastCandidates = 128;
/// The fraction of a greater depth that is taken away in a tick. 1 would throw a body that was put into a plane out of
/// it.
constexpr double kLift = 0.1;

/// A point of the body by a plane, ready to be solved.
struct Touch {
  std::uint16_t plane = 0;
  std::uint16_t point = 0;
  Vec3 normal{0};
  Vec3 along[2];  // two directions in the plane
  Vec3 arm{0};    // from the centre of mass, world
  double friction = 0;
  double rolling = 0;   // m
  double closing = 0;   // speed at which it may still come nearer, m/s
  double pressing = 0;  // impulses so far, Ns
  double rubbing[2] = {0, 0};
  double mass[3] = {0, 0, 0};  // effective, along the normal and the two directions, kg

  [[nodiscard]] Vec3 impulse() const noexcept {
    return pressing * normal + rubbing[0] * along[0] + rubbing[1] * along[1];
  }
};

/// Momenta and velocities of a body whose attitude stands still while impulses act on it.
class Impulses {
 public:
  Impulses(const RigidBody& body, RigidState& state) noexcept
      : state_(state), turn_(glm::mat3_cast(state.axes)), perMass_(1 / body.mass.mass_kg) {
    const glm::dmat3 scaled(turn_[0] / body.mass.moments.x, turn_[1] / body.mass.moments.y,
                            turn_[2] / body.mass.moments.z);
    perInertia_ = scaled * glm::transpose(turn_);
    linear_ = perMass_ * state.momentum_Ns;
    angular_ = perInertia_ * state.angularMomentum_Nms;
  }
  [[nodiscard]] Vec3 arm(Vec3 support) const noexcept { return turn_ * support; }
  [[nodiscard]] double reach(double radius, double period_s) const noexcept {
    return (glm::length(linear_) + glm::length(angular_) * radius) * period_s;
  }
  [[nodiscard]] Vec3 linear() const noexcept { return linear_; }
  [[nodiscard]] Vec3 angular() const noexcept { return angular_; }
  [[nodiscard]] Vec3 velocity(Vec3 arm) const noexcept { return linear_ + glm::cross(angular_, arm); }
  [[nodiscard]] double effectiveMass(Vec3 arm, Vec3 direction) const noexcept {
    const Vec3 lever = glm::cross(arm, direction);
    return 1 / (perMass_ + glm::dot(lever, perInertia_ * lever));
  }
  void apply(Vec3 arm, Vec3 impulse) noexcept {
    const Vec3 turning = glm::cross(arm, impulse);
    state_.momentum_Ns += impulse;
    state_.angularMomentum_Nms += turning;
    linear_ += perMass_ * impulse;
    angular_ += perInertia_ * turning;
  }
  void applyTurning(Vec3 turning) noexcept {
    state_.angularMomentum_Nms += turning;
    angular_ += perInertia_ * turning;
  }
  /// All of it, as angular_ is made from it.
  [[nodiscard]] Vec3 angularMomentum() const noexcept { return state_.angularMomentum_Nms; }

 private:
  RigidState& state_;
  glm::dmat3 turn_;
  double perMass_;
  glm::dmat3 perInertia_;
  Vec3 linear_;
  Vec3 angular_;
};

/// How far a support point (principal frame, m) is above a plane.
struct Above {
  double height = 0;  ///< Of the centre of mass.
  Vec3 normal{0};

  [[nodiscard]] double operator()(Vec3 support) const noexcept { return height + glm::dot(normal, support); }
};

/// The support points within reach of a plane that span the body's support polygon. In the principal frame.
class Footprint {
 public:
  /// @param next  At the tick's end, if the plane were not there.
  /// @param reach  m, how far the body gets in the tick, besides what counts as near.
  Footprint(const RigidBody& body, const Above& now, const Above& next, double reach_m) noexcept
      : support_(body.support), normal_(now.normal), next_(next) {
    const double near_m = kNear * body.radius_m, reach = reach_m + near_m;
    const auto count = static_cast<std::uint16_t>(std::min<std::size_t>(support_.size(), near_.size()));
    std::uint16_t i = 0;
    // Two at once: of bodies with many points this is most of the work.
    const Vec3 n = now.normal;
    const __m128d xy = _mm_setr_pd(n.x, n.y), zx = _mm_setr_pd(n.z, n.x), yz = _mm_setr_pd(n.y, n.z);
    const __m128d most = _mm_set1_pd(reach - now.height);
    for (; i + 1 < count; i = static_cast<std::uint16_t>(i + 2)) {
      const double* const both = &support_[i].x;
      const __m128d height =
          _mm_loadu_pd(both + 2) * zx + _mm_hadd_pd(_mm_loadu_pd(both) * xy, _mm_loadu_pd(both + 4) * yz);
      const int near = _mm_movemask_pd(_mm_cmple_pd(height, most));
      if (near == 0) [[likely]]
        continue;
      if ((near & 1) != 0) near_[count_++] = i;
      if ((near & 2) != 0) near_[count_++] = static_cast<std::uint16_t>(i + 1);
    }
    if (i < count && now(support_[i]) <= reach) near_[count_++] = i;
    if (reach_m > near_m) stride_ = 1 + count_ / kFastCandidates;
  }

  /// Units (Allowance) of looking for them.
  [[nodiscard]] std::int64_t units() const noexcept {
    return kPoint * static_cast<std::int64_t>(support_.size()) + kPointByPlane * static_cast<std::int64_t>(count_) +
           kCandidate * static_cast<std::int64_t>(count_ / stride_);
  }

  /// Calls `take` with the point that would go deepest; the one farthest from it; the ones farthest to both sides of these two.
  template <class Take>
  void choose(Take take) const noexcept {
    if (count_ == 0) return;
    const std::uint16_t a = best(1, [&](std::uint16_t i) { return -next_(support_[i]); });
    take(a);
    const std::uint16_t b = best(stride_, [&](std::uint16_t i) { return squaredLength(support_[i] - support_[a]); });
    if (b == a) return;
    take(b);
    const Vec3 across = glm::cross(normal_, support_[b] - support_[a]);
    const double least = 1e-6 * squaredLength(across);  // beside the line by more than rounding
    std::uint16_t left = a, right = a;
    double mostLeft = least, mostRight = -least;
    for (std::size_t k = 0; k < count_; k += stride_) {
      const double side = glm::dot(across, support_[near_[k]] - support_[a]);
      if (side > mostLeft) {
        mostLeft = side;
        left = near_[k];
      } else if (side < mostRight) {
        mostRight = side;
        right = near_[k];
      }
    }
    if (left != a) take(left);
    if (right != a) take(right);
  }

 private:
  template <class Score>
  [[nodiscard]] std::uint16_t best(std::size_t stride, Score score) const noexcept {
    std::uint16_t which = near_[0];
    double most = score(which);
    for (std::size_t k = stride; k < count_; k += stride) {
      const double here = score(near_[k]);
      if (here > most) {
        most = here;
        which = near_[k];
      }
    }
    return which;
  }

  const std::vector<Vec3>& support_;
  Vec3 normal_;
  Above next_;
  std::array<std::uint16_t, kSupportDirections> near_;  // NOLINT: filled as far as count_
  std::size_t count_ = 0;
  std::size_t stride_ = 1;  // of those that are chosen from
};

/// What this point was given in the last tick.
[[nodiscard]] Vec3 lastImpulse(const RigidState& state, std::size_t plane, std::uint16_t point) noexcept {
  for (const PlanePoint& was : state.touching.all()) {
    if (was.plane == plane && was.point == point) return was.impulse_Ns;
  }
  return Vec3(0);
}

[[nodiscard]] Touch makeTouch(const Plane& plane, Vec3 arm, double closing, Vec3 guess,
                              const Impulses& impulses) noexcept {
  Touch touch;
  touch.normal = plane.normal;
  const Vec3 aside = std::abs(plane.normal.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  touch.along[0] = glm::normalize(glm::cross(plane.normal, aside));
  touch.along[1] = glm::cross(plane.normal, touch.along[0]);
  touch.arm = arm;
  touch.friction = plane.friction;
  touch.rolling = plane.rolling_m;
  touch.closing = closing;
  touch.mass[0] = impulses.effectiveMass(arm, touch.normal);
  touch.mass[1] = impulses.effectiveMass(arm, touch.along[0]);
  touch.mass[2] = impulses.effectiveMass(arm, touch.along[1]);
  touch.pressing = std::max(glm::dot(guess, touch.normal), 0.0);
  touch.rubbing[0] = glm::dot(guess, touch.along[0]);
  touch.rubbing[1] = glm::dot(guess, touch.along[1]);
  return touch;
}

/// @return By how much it changed its impulses, Ns.
double solve(Touch& t, Impulses& impulses) noexcept {
  const double approach = glm::dot(impulses.velocity(t.arm), t.normal) + t.closing;
  const double pressing = std::max(t.pressing - t.mass[0] * approach, 0.0);
  impulses.apply(t.arm, (pressing - t.pressing) * t.normal);
  double change = std::abs(pressing - t.pressing);
  t.pressing = pressing;

  const Vec3 sliding = impulses.velocity(t.arm);
  double rubbing[2];
  for (int k = 0; k < 2; ++k) rubbing[k] = t.rubbing[k] - t.mass[k + 1] * glm::dot(sliding, t.along[k]);
  const double most = t.friction * t.pressing;
  const double wanted = elementary::hypot(rubbing[0], rubbing[1]);
  const double part = wanted > most ? most / wanted : 1;
  for (int k = 0; k < 2; ++k) {
    impulses.apply(t.arm, (part * rubbing[k] - t.rubbing[k]) * t.along[k]);
    change += std::abs(part * rubbing[k] - t.rubbing[k]);
    t.rubbing[k] = part * rubbing[k];
  }
  return change;
}

/// Turning about the points themselves, which no force at them stops.
void resistRolling(std::span<const Touch> touches, Vec3& rolling, Impulses& impulses) noexcept {
  double most = 0;
  for (const Touch& t : touches) most += t.rolling * t.pressing;
  const Vec3 wanted = rolling - impulses.angularMomentum();
  const double size = glm::length(wanted);
  const Vec3 given = size > most ? most / size * wanted : wanted;
  impulses.applyTurning(given - rolling);
  rolling = given;
}

using Touches = std::array<Touch, kMaxPlanes * kPointsOnPlane>;

/// Calls `take(plane, point, gap)` for support points that may reach a plane within the tick.
template <class Take>
void visitNearPlanes(const RigidBody& body, const RigidState& state, const Impulses& impulses, double period_s,
                     Allowance& allowance, Take take) noexcept {
  const double reach_m = impulses.reach(body.radius_m, period_s);
  for (std::size_t p = 0; p < body.planeCount; ++p) {
    const Plane& plane = body.planes[p];
    const double height = glm::dot(plane.normal, state.centre_m) - plane.offset_m;
    if (height - body.radius_m > reach_m + kNear * body.radius_m) continue;
    const Quat toOwn = glm::conjugate(state.axes);
    const Above now{height, toOwn * plane.normal};
    const Above next{height + period_s * glm::dot(plane.normal, impulses.linear()),
                     now.normal + period_s * (toOwn * glm::cross(plane.normal, impulses.angular()))};
    const Footprint footprint(body, now, next, reach_m);
    allowance.spend(footprint.units());
    footprint.choose(
        [&](std::uint16_t point) { take(static_cast<std::uint16_t>(p), point, now(body.support[point])); });
  }
}

/// @return How many there are.
[[nodiscard]] std::size_t findTouches(const RigidBody& body, const RigidState& state, const Impulses& impulses,
                                      double period_s, Touches& touches, Allowance& allowance) noexcept {
  std::size_t count = 0;
  visitNearPlanes(body, state, impulses, period_s, allowance, [&](std::uint16_t p, std::uint16_t point, double gap) {
    const double closing = std::max(gap, 0.0) / period_s;
    Touch& touch = touches[count++];
    touch =
        makeTouch(body.planes[p], impulses.arm(body.support[point]), closing, lastImpulse(state, p, point), impulses);
    touch.plane = p;
    touch.point = point;
  });
  allowance.spend(kBearing * static_cast<std::int64_t>(count));
  return count;
}

}  // namespace

std::size_t findNearPlanes(const RigidBody& body, const RigidState& state, double period_s, NearPlanes& found,
                           Allowance& allowance) noexcept {
  if (body.planeCount == 0) return 0;
  RigidState same = state;
  const Impulses impulses(body, same);
  std::size_t count = 0;
  visitNearPlanes(body, state, impulses, period_s, allowance, [&](std::uint16_t p, std::uint16_t point, double gap) {
    found[count++] = {p, point, impulses.arm(body.support[point]), gap, lastImpulse(state, p, point)};
  });
  return count;
}

std::int64_t leastPlaneUnits(const RigidBody& body, const RigidState& state) noexcept {
  double parts = 0, partsByPlanes = 0;  // of the body's points
  for (std::size_t p = 0; p < body.planeCount; ++p) {
    const Plane& plane = body.planes[p];
    const double below_m = body.radius_m - (glm::dot(plane.normal, state.centre_m) - plane.offset_m);
    if (!(below_m > 0)) continue;
    parts += 1;
    partsByPlanes += std::min(1.0, below_m / (2 * body.radius_m));
  }
  const auto points = static_cast<double>(body.support.size());
  return static_cast<std::int64_t>(points * (kPoint * parts + (kPointByPlane + kCandidate) * partsByPlanes)) +
         kBearing * static_cast<std::int64_t>(state.touching.count);
}

void solvePlaneContacts(const RigidBody& body, RigidState& state, double period_s,
                        MotionAllowance& allowance) noexcept {
  if (body.planeCount == 0) return;
  Impulses impulses(body, state);
  Touches touches;
  const std::size_t count = findTouches(body, state, impulses, period_s, touches, allowance.least);
  for (std::size_t i = 0; i < count; ++i) impulses.apply(touches[i].arm, touches[i].impulse());
  Vec3 rolling(0);
  if (count > 0) {
    rolling = state.rolling_Nms;
    impulses.applyTurning(rolling);
  }
  for (int round = 0; round < kRounds && count > 0; ++round) {
    if (round >= kMinRounds) {
      if (allowance.rounds.isSpent()) break;
      allowance.rounds.spend(kRound * static_cast<std::int64_t>(count));
    }
    double change = 0;
    double pressing = 0;
    for (std::size_t i = 0; i < count; ++i) {
      change += solve(touches[i], impulses);
      pressing += touches[i].pressing;
    }
    resistRolling({touches.data(), count}, rolling, impulses);
    if (change <= kSettled * pressing) break;
  }
  state.rolling_Nms = rolling;
  for (std::size_t i = 0; i < count; ++i) {
    state.touching[i] = {touches[i].plane, touches[i].point, touches[i].impulse()};
  }
  state.touching.count = count;
}

void leavePlanes(const RigidBody& body, RigidState& state) noexcept {
  for (const PlanePoint& at : state.touching.all()) {
    const Plane& plane = body.planes[at.plane];
    const Vec3 place = state.centre_m + state.axes * body.support[at.point];
    const double depth = plane.offset_m - glm::dot(plane.normal, place);
    const double slop = kSlop * body.radius_m;
    if (depth > slop) state.centre_m += kLift * (depth - slop) * plane.normal;
  }
}

}  // namespace haptics
