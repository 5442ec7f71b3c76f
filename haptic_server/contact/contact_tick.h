#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "haptic_server/contact/constraints.h"
#include "haptic_server/contact/contact.h"
#include "haptic_server/contact/corrections.h"
#include "haptic_server/contact/hip_following.h"
#include "haptic_server/contact/near_bodies.h"
#include "haptic_server/contact/neighborhood_watch.h"
#include "haptic_server/contact/tolerances.h"

namespace haptics {

/// Finite, and within the range of the float vertices.
[[nodiscard]] inline bool isUsable(Vec3 hip) noexcept {
  constexpr double kFarthest = std::numeric_limits<float>::max();
  return std::abs(hip.x) <= kFarthest && std::abs(hip.y) <= kFarthest && std::abs(hip.z) <= kFarthest;  // not for NaN
}

/// One tick at work on the state: the neighborhood watch proposes a path, a guard tests it against everything else that
/// is near, and a constraint solver takes over only where it is blocked, at boundaries, and while several surfaces
/// hold.
class ContactTick {
 public:
  ContactTick(std::span<const Body> bodies, ContactState& state, Vec3 hip, const Allowance& allowance,
              const Corrections& corrections) noexcept;
  [[nodiscard]] ContactResult run() noexcept;

 private:
  using Near = NearBodies::Near;
  using Hit = NearBodies::Hit;
  using Points = NearBodies::Points;
  using Mode = ContactState::Mode;

  /// What a step changes of the state.
  struct Checkpoint {
    Mode mode;
    int holdingCount;
    std::array<ContactSurface, ContactState::kMaxHolding> holding;
    Feature feature;
    Vec3 local;
    Vec3 ihip;
    ClosestPoint foot;
    bool settled;
  };

  // contact_tick.cpp: the tick in steps
  void start() noexcept;
  void makeSteps() noexcept;
  void carryWithBody() noexcept;
  [[nodiscard]] Checkpoint checkpoint() const noexcept;
  void restore(const Checkpoint& before) noexcept;
  [[nodiscard]] double shortStepEnd(double now) const noexcept;
  [[nodiscard]] double advance(double now, bool last, const Checkpoint& before) noexcept;
  [[nodiscard]] Vec3 hipAt(double time) const noexcept { return time < 1 ? glm::mix(state_.hip, hip_, time) : hip_; }
  /// Moves all bodies to a fraction of the tick's path.
  void setTime(double time) noexcept { near_.setTime(bodies_, corrections_.objectFrameSegments ? time * stride_ : 1); }
  [[nodiscard]] ContactResult result() noexcept;

  // free_motion.cpp: motion in free space
  [[nodiscard]] double advanceFree(double now, double end, Vec3 hip) noexcept;
  /// Bodies that are leaving the scene cannot be touched anew.
  template <class Skip>
  [[nodiscard]] Hit firstNewContact(const Points& to, Skip skip) noexcept {
    return near_.firstHit(
        to, [&](int i, std::uint32_t t) noexcept { return near_[i].pendingRemoval || skip(i, t); }, work_);
  }
  void touch(const Hit& hit, const Points& to) noexcept;
  void setFree(Vec3 hip) noexcept;
  void hold(const ContactSurface& surface, const ClosestPoint& foot, Vec3 ihip) noexcept;

  // containment.cpp: an IHIP that is inside of a body
  [[nodiscard]] bool mayBeInside() const noexcept;
  [[nodiscard, gnu::noinline]] int enclosingBody() noexcept;
  [[nodiscard, gnu::noinline]] bool depenetrate() noexcept;

  // surface_following.cpp: one surface
  [[nodiscard]] SearchResult search(const ContactSurface& from, Vec3 h, SearchPath* path) noexcept;
  [[nodiscard]] HipMotion motionOver(const Body& body) const noexcept;
  [[nodiscard]] double advanceOnSurface(double now, bool last) noexcept;
  void followSurface(Vec3 hip) noexcept;
  [[nodiscard]] bool isGuarded(const CollisionMesh& surface) const noexcept {
    return corrections_.guard && (near_.count() > 1 || surface.anySelfIntersecting());
  }
  [[nodiscard]] bool settle(const SearchResult& found, const SearchPath& path, Vec3 h, Vec3 hip) noexcept;
  [[nodiscard]] bool isOutside(const CollisionMesh& surface, const ClosestPoint& foot, Vec3 h) const noexcept;
  [[nodiscard]] bool pathIsClear(const SearchPath& path, const Frame& frame) noexcept;
  [[nodiscard]] bool pieceIsClear(std::uint32_t within, Vec3 b, const Frame& frame) noexcept;
  /// Above the surface, by metres.
  [[nodiscard]] Vec3 lifted(Vec3 at, const ContactSurface& over, double height) const noexcept {
    return at + surface(over.body).faceNormal(over.triangle) * (over.side * height);
  }
  void leave(const ClosestPoint& foot, Vec3 h, Vec3 hip) noexcept;

  // constraint_solver.cpp: several surfaces
  void resolve(Vec3 hip) noexcept;
  void stayInPlace() noexcept;
  void solve(Vec3 hip) noexcept;
  [[nodiscard]] SolverStep moveTowards(Vec3 hip, double longest_m) noexcept;
  /// Do two triangles share a vertex?
  [[nodiscard]] bool shareVertex(const ContactSurface& a, const ContactSurface& b) const noexcept;
  /// Does another part of its mesh pass through the triangle?
  [[nodiscard]] bool isSelfIntersecting(const ContactSurface& s) const noexcept {
    return corrections_.guard && corrections_.severalSurfaces &&
           surface(s.body).triangle(s.triangle).selfIntersecting();
  }
  [[nodiscard]] Hit tryMoveTo(Vec3 world) noexcept;
  [[nodiscard]] bool isBlockedByOther(const Near& own, Vec3 world) noexcept;
  [[nodiscard]] bool isWithin(double skins, const ContactSurface& s) const noexcept;
  [[nodiscard]] bool isSupportedBy(const SolverStep& move) const noexcept;
  [[nodiscard]] ConstraintPlane planeOf(const ContactSurface& holding) const noexcept;
  void updateMode(Vec3 hip, const SolverStep& move, bool settled) noexcept;

  // active_set.cpp: surfaces that are known to hold
  [[nodiscard]] SolverStep followActiveSet(Vec3 hip) noexcept;
  [[nodiscard]] ActiveSet oneOfEachBody() const noexcept;
  [[nodiscard]] SupportLimit supportLimit(std::span<const ContactSurface> surfaces,
                                          const Constraints& constraints) const noexcept;
  [[nodiscard]] bool hasPendingBodyMotion() const noexcept;
  [[nodiscard]] bool leavesRoomAcross(const ContactSurface& s, int k, const Constraints& constraints) const noexcept;
  [[nodiscard]] std::optional<ContactSurface> across(const ContactSurface& s, int k) const noexcept;
  [[nodiscard]] std::optional<ActiveSet> crossConvexEdge(Vec3 hip, const ActiveSet& held,
                                                         const Constraints& constraints) const noexcept;
  [[nodiscard]] bool isConvexEdge(const ContactSurface& s, int k) const noexcept;
  void resolveRidge(const ActiveSet& a, const ActiveSet& b, SolverStep& move) const noexcept;
  [[nodiscard]] SolverStep onEdge(const ActiveSet& held, const ContactSurface& left) const noexcept;
  [[nodiscard]] std::optional<ContactSurface> nearestTouched(Vec3 hip, const SolverStep& move) const noexcept;
  [[nodiscard]] bool continueWatch(Vec3 hip, SolverStep& move) noexcept;
  [[nodiscard]] bool isOneSurface(const SolverStep& move) const noexcept;

  // several_surfaces.cpp: steps while several surfaces hold
  [[nodiscard]] double advanceOnSeveral(double now, double end, const Checkpoint& before) noexcept;
  [[nodiscard]] bool isFast(double step, const ContactSurface& over) const noexcept;
  void solveAt(double time) noexcept;
  [[nodiscard]] double heldUntil(double now, double end) const noexcept;
  [[nodiscard]] std::optional<Constraints> heldAt(const ActiveSet& held, double time) const noexcept;
  [[nodiscard]] bool staysOn(const ActiveSet& held, double time) const noexcept;

  [[nodiscard]] const CollisionMesh& surface(int body) const noexcept {
    return *bodies_[static_cast<std::size_t>(body)].surface;
  }
  [[nodiscard]] ContactSurface& held() noexcept { return state_.holding[0]; }
  [[nodiscard]] const ContactSurface& held() const noexcept { return state_.holding[0]; }
  [[nodiscard]] Near& heldNear() noexcept { return near_[near_.indexOf(held().body)]; }

  const Corrections& corrections_;
  std::span<const Body> bodies_;
  ContactState& state_;
  double stride_;  // of the HIP's way and the bodies' motions, the part that this tick sets out to take
  Vec3 hip_;       // at the end of it, world
  NearBodies near_;
  ClosestPoint foot_;     // kOneSurface: of the IHIP
  bool settled_ = false;  // It is the nearest to the HIP.
  double skin_ = 0;       // metres
  double pathOffset_ = 0;
  double startOffset_ = 0;
  bool recordedOnly_ = false;  // touched in this tick, to be searched in the next (sameTickSearch off)
  ContactWork work_;
};

/// Every tick by the general path, whatever it costs: what followContact() does. Into a `result` as constructed, but for
/// its allowance.
void followGuarded(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   const Corrections& corrections = kAllCorrections) noexcept;

}  // namespace haptics
