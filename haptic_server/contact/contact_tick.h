#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "haptic_server/contact/contact.h"
#include "haptic_server/contact/hip_following.h"
#include "haptic_server/contact/near_bodies.h"
#include "haptic_server/contact/neighborhood_watch.h"
#include "haptic_server/contact/plane_set.h"

namespace haptics {

/// Of a triangle's size (root of twice its area) that the HIP advances per step while several surfaces hold the IHIP, so
/// that the solver follows the path that a slow hand would take. Larger jumps over creases; smaller costs time.
inline constexpr double kStepFraction = 0.5;
/// No such step is a smaller fraction of the tick.
inline constexpr double kLeastShortStep = 0x1p-4;
/// Is a motion of the HIP (squared, m^2) no more than a step over a triangle (square of twice its area, m^4)?
[[nodiscard]] constexpr bool inOneStep(double squaredStep, double squaredTwiceArea) noexcept {
  constexpr double kFraction2 = kStepFraction * kStepFraction;
  return squaredStep * squaredStep <= kFraction2 * kFraction2 * squaredTwiceArea;
}
/// Rounds of the constraint solver in a step. Each meets the planes anew from where the last one came to. Fewer leave a
/// long slide along a seam to the next tick, with a force that is a tick late; more make the longest tick longer.
inline constexpr int kMaxSolverRounds = 64;

/// Lengths are fractions of the largest coordinate in reach, powers of two, so that nothing depends on the unit.
/// Vertices are floats (2^-24 of the extent), arithmetic is double (2^-52).
///
/// How far the IHIP stays above the surfaces that it passes, or is held by several of: it cannot enter a thinner gap,
/// and misfits of bodies that touch, which are of the order of 2^-24, stay hidden under it.
inline constexpr double kSkin = 0x1p-20;
/// How far above the surface that holds it the path of an IHIP is tested against other bodies: it can be so deep inside of
/// what rises from that surface. Smaller shows misfits; larger leaves more of the IHIP inside.
inline constexpr double kPathLift = 0x1p-22;
/// How far above its own triangle a segment starts: far more than the arithmetic's rounding, far less than the
/// vertices'.
inline constexpr double kLift = 0x1p-32;
/// Of the skin: a plane is held when the IHIP is not farther below it.
inline constexpr double kSlack = 0x1p-2;
/// Times the HIP's step: an IHIP that went farther slid from a minimum that ended on the way. Larger lets it begin with a
/// HIP that is too far on already; smaller divides steps over creases.
inline constexpr double kLeap = 4;
/// The same for a step that is not short beside the triangles: a slide over some of them is hardly longer.
inline constexpr double kLeapOfFast = 0x1.2p0;
/// In skins: what is not farther on the way holds the IHIP, anything else is gone to first. Larger cuts corners; smaller
/// takes more rounds in acute grooves.
inline constexpr double kTouching = 16;
/// In skins: closer than this to an edge is on it. The skin hides what is smaller.
inline constexpr double kHair = 0x1p-10;
/// In skins: a triangle that is not farther is under the IHIP, held by the lifted planes of several.
inline constexpr double kUnder = 2;
/// In skins: from where the neighborhood watch goes on over a triangle.
inline constexpr double kAbove = 4;
/// Rounds of a step that may end no nearer to the HIP: the skin lifts the IHIP where another surface begins to hold it.
inline constexpr int kMostNotNearer = 2;
/// In skins: an IHIP that is no deeper inside a body is on its surface. The vertices' rounding hides what is smaller.
inline constexpr double kDeep = 0x1p-4;
/// A solver round that moves the IHIP by less than this fraction of the penetration ends the step.
inline constexpr double kSettled = 0x1p-14;

/// Finite, and within the range of the float vertices.
[[nodiscard]] inline bool isUsable(Vec3 hip) noexcept {
  constexpr double kFarthest = std::numeric_limits<float>::max();
  return std::abs(hip.x) <= kFarthest && std::abs(hip.y) <= kFarthest && std::abs(hip.z) <= kFarthest;  // not for NaN
}
/// The HIP that a tick goes to: one that is not usable has not moved.
[[nodiscard]] inline Vec3 usableHip(const ContactState& state, Vec3 hip) noexcept {
  return isUsable(hip) ? hip : state.hip;
}

/// Triangles that a search may have looked at in this tick when it ends: it takes half of the allowance at most.
[[nodiscard]] inline int searchBudget(const ContactWork& work) noexcept {
  const std::int64_t affordable = work.triangles + work.allowance.left() / (2 * Allowance::kNearTriangle);
  return static_cast<int>(std::clamp<std::int64_t>(affordable, 1, kSearchBudget));
}

/// One tick at work on the state: the neighborhood watch proposes a path, a guard tests it against everything else that
/// is near, and a constraint solver takes over only where it is blocked, at boundaries, and while several surfaces
/// hold.
template <class Corrections>
class ContactTick {
 public:
  ContactTick(std::span<const Body> bodies, ContactState& state, Vec3 hip, const Allowance& allowance) noexcept;
  [[nodiscard, gnu::always_inline]] inline ContactResult run() noexcept;

 private:
  using Near = NearBodies::Near;
  using Hit = NearBodies::Hit;
  using Points = NearBodies::Points;
  using Mode = ContactState::Mode;
  using SegmentTest = typename Corrections::SegmentTest;

  /// What a step changes of the state.
  struct Checkpoint;

  // contact_tick_impl.h: the tick in steps, motion in free space
  void start() noexcept;
  void makeSteps() noexcept;
  [[nodiscard]] Checkpoint checkpoint() const noexcept;
  void restore(const Checkpoint& before) noexcept;
  [[nodiscard]] double shortStepEnd(double now) const noexcept;
  [[nodiscard]] double advance(double now, bool last, const Checkpoint& before) noexcept;
  [[nodiscard]] Vec3 hipAt(double time) const noexcept { return time < 1 ? glm::mix(state_.hip, hip_, time) : hip_; }
  /// Of the way that the tick sets out to take.
  void setTime(double time) noexcept { near_.setTime(bodies_, Corrections::kObjectFrameSegments ? time * stride_ : 1); }
  [[nodiscard]] double advanceFree(double now, double end, Vec3 hip) noexcept;
  /// Bodies that are leaving the scene cannot be touched anew.
  template <class Skip>
  [[nodiscard]] Hit firstNewContact(const Points& to, Skip skip) noexcept {
    return near_.template firstHit<SegmentTest>(
        to, [&](int i, std::uint32_t t) noexcept { return near_[i].leaving || skip(i, t); }, work_);
  }
  void touch(const Hit& hit, const Points& to) noexcept;
  void setFree(Vec3 hip) noexcept;
  void hold(const HoldingSurface& surface, const Foot& foot, Vec3 ihip) noexcept;
  [[nodiscard]] bool mayBeInside() const noexcept;
  [[nodiscard, gnu::noinline]] int enclosingBody() noexcept;
  [[gnu::noinline]] void putOut() noexcept;
  [[nodiscard]] ContactResult result() noexcept;

  // surface_following_impl.h: one surface
  [[nodiscard]] SearchResult search(const HoldingSurface& from, Vec3 h, SearchPath* path) noexcept;
  [[nodiscard]] HipMotion motionOver(const Body& body) const noexcept;
  [[nodiscard]] double advanceOnSurface(double now, bool last) noexcept;
  void followSurface(Vec3 hip) noexcept;
  [[nodiscard]] bool isGuarded(const Surface& surface) const noexcept {
    return Corrections::kGuard && (near_.count() > 1 || surface.anyCrossed());
  }
  [[nodiscard]] bool settle(const SearchResult& found, const SearchPath& path, Vec3 h, Vec3 hip) noexcept;
  [[nodiscard]] bool isOutside(const Surface& surface, const Foot& foot, Vec3 h) const noexcept;
  [[nodiscard]] bool pathIsClear(const SearchPath& path, const Frame& frame) noexcept;
  [[nodiscard]] bool pieceIsClear(std::uint32_t within, Vec3 b, const Frame& frame) noexcept;
  /// Above the surface, by metres.
  [[nodiscard]] Vec3 lifted(Vec3 at, const HoldingSurface& over, double height) const noexcept {
    return at + surface(over.body).faceNormal(over.triangle) * (over.side * height);
  }
  void leave(const Foot& foot, Vec3 h, Vec3 hip) noexcept;

  // constraint_solver_impl.h: several surfaces
  struct Constraints;
  struct Holding;
  struct Move;
  struct Carried;
  void resolve(Vec3 hip) noexcept;
  void stay() noexcept;
  void solve(Vec3 hip) noexcept;
  [[nodiscard]] Move moveTowards(Vec3 hip, double longest_m) noexcept;
  /// Do two triangles share a vertex?
  [[nodiscard]] bool meet(const HoldingSurface& a, const HoldingSurface& b) const noexcept;
  /// Does another part of its mesh pass through the triangle?
  [[nodiscard]] bool isCrossed(const HoldingSurface& s) const noexcept {
    return Corrections::kGuard && Corrections::kSeveralSurfaces && surface(s.body).triangle(s.triangle).crossed();
  }
  [[nodiscard]] Hit go(Vec3 world) noexcept;
  [[nodiscard]] bool meetsAnother(const Near& own, Vec3 world) noexcept;
  [[nodiscard]] bool isWithin(double skins, const HoldingSurface& s) const noexcept;
  [[nodiscard]] bool restsOn(const Move& move) const noexcept;
  [[nodiscard]] ConstraintPlane planeOf(const HoldingSurface& holding) const noexcept;
  void classify(Vec3 hip, const Move& move, bool settled) noexcept;

  // held_surfaces_impl.h: surfaces that are known to hold
  [[nodiscard]] Move followHeld(Vec3 hip) noexcept;
  [[nodiscard]] Holding oneOfEachBody() const noexcept;
  [[nodiscard]] Carried carriedBy(std::span<const HoldingSurface> surfaces,
                                  const Constraints& constraints) const noexcept;
  [[nodiscard]] bool isBehind() const noexcept;
  [[nodiscard]] bool fallsAway(const HoldingSurface& s, int k, const Constraints& constraints) const noexcept;
  [[nodiscard]] std::optional<HoldingSurface> across(const HoldingSurface& s, int k) const noexcept;
  [[nodiscard]] std::optional<Holding> roundTheEdge(Vec3 hip, const Holding& held,
                                                    const Constraints& constraints) const noexcept;
  [[nodiscard]] bool jutsOut(const HoldingSurface& s, int k) const noexcept;
  void restBetween(const Holding& a, const Holding& b, Move& move) const noexcept;
  [[nodiscard]] Move onEdge(const Holding& held, const HoldingSurface& left) const noexcept;
  [[nodiscard]] std::optional<HoldingSurface> nearestTouched(Vec3 hip, const Move& move) const noexcept;
  [[nodiscard]] bool watchOn(Vec3 hip, Move& move) noexcept;
  [[nodiscard]] bool isOneSurface(const Move& move) const noexcept;

  // several_surfaces_impl.h: steps while several surfaces hold
  [[nodiscard]] double advanceOnSeveral(double now, double end, const Checkpoint& before) noexcept;
  [[nodiscard]] bool isFast(double step, const HoldingSurface& over) const noexcept;
  void solveAt(double time) noexcept;
  [[nodiscard]] double heldUntil(double now, double end) const noexcept;
  template <class Holds>
  [[nodiscard]] double lastTime(double now, double end, Holds holds) const noexcept;
  [[nodiscard]] std::optional<Constraints> heldAt(const Holding& held, double time) const noexcept;
  [[nodiscard]] bool staysOn(const Holding& held, double time) const noexcept;

  [[nodiscard]] const Surface& surface(int body) const noexcept {
    return *bodies_[static_cast<std::size_t>(body)].surface;
  }
  [[nodiscard]] HoldingSurface& held() noexcept { return state_.holding[0]; }
  [[nodiscard]] const HoldingSurface& held() const noexcept { return state_.holding[0]; }
  [[nodiscard]] Near& heldNear() noexcept { return near_[near_.indexOf(held().body)]; }

  std::span<const Body> bodies_;
  ContactState& state_;
  double stride_;  // of the HIP's way and the bodies' motions, the part that this tick sets out to take
  Vec3 hip_;       // at the end of it, world
  NearBodies near_;
  Foot foot_;             // kOneSurface: of the IHIP
  bool settled_ = false;  // It is the nearest to the HIP.
  double skin_ = 0;       // metres
  double pathLift_ = 0;
  double lift_ = 0;
  bool recordedOnly_ = false;  // touched in this tick, to be searched in the next (kSameTickSearch off)
  ContactWork work_;
};

}  // namespace haptics
