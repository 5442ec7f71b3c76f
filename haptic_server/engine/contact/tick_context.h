#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/corrections.h"
#include "haptic_server/engine/contact/near_bodies.h"
#include "haptic_server/engine/contact/search_path.h"
#include "haptic_server/engine/contact/tolerances.h"

namespace haptics {

/// What a step changes of the state.
struct Checkpoint {
  ContactState::Mode mode;
  std::int32_t holdingCount;
  std::array<ContactSurface, ContactState::kMaxHolding> holding;
  Feature feature;
  Vec3 local;
  Vec3 ihip;
  ClosestPoint foot;
  bool footConverged;
};

/// What free motion, surface walk and plane solver share in a tick: the state, the bodies near, the path of the HIP and
/// the tolerances. Each part changes the mode through it; contact_tick.cpp runs the part of the mode.
struct TickContext {
  using Mode = ContactState::Mode;

  /// `hip` has to be usable.
  TickContext(std::span<const Body> sceneBodies, ContactState& contactState, Vec3 hipAtEnd, const Allowance& allowance,
              const Corrections& switches) noexcept
      : corrections(switches),
        bodies(sceneBodies),
        state(contactState),
        stride(contactState.stride),
        goal(hipAtEnd),
        hip(stride < 1 ? glm::mix(contactState.hip, hipAtEnd, stride) : hipAtEnd),
        near(switches.segmentTest) {
    work.allowance = allowance;
  }

  [[nodiscard]] Vec3 hipAt(double time) const noexcept { return time < 1 ? glm::mix(state.hip, hip, time) : hip; }
  /// Moves all near bodies to a fraction of the tick's path.
  void setTime(double time) noexcept { near.setTime(bodies, corrections.objectFrameSegments ? time * stride : 1); }

  [[nodiscard]] const Body& body(int i) const noexcept { return bodies[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const CollisionMesh& surface(int i) const noexcept { return *body(i).surface; }
  [[nodiscard]] ContactSurface& held() noexcept { return state.holding[0]; }
  [[nodiscard]] const ContactSurface& held() const noexcept { return state.holding[0]; }
  [[nodiscard]] const NearBodies::Near& nearOf(const ContactSurface& s) const noexcept {
    return near[near.indexOf(s.body)];
  }
  /// Above a surface, by metres; in the body's frame.
  [[nodiscard]] Vec3 lifted(Vec3 point, const ContactSurface& s, double height) const noexcept {
    return point + surface(s.body).faceNormal(s.triangle) * (s.side * height);
  }
  /// Does another part of its mesh pass through the triangle?
  [[nodiscard]] bool isSelfIntersecting(const ContactSurface& s) const noexcept {
    return corrections.guard && corrections.severalSurfaces && surface(s.body).triangle(s.triangle).selfIntersecting();
  }

  /// After searches that began where `work` was.
  void countLooked(const SearchRun& run) noexcept {
    work.allowance.spend(Allowance::kNearTriangle * (run.looked - work.triangles));
    work.triangles = run.looked;
  }

  void setFree(Vec3 ihip) noexcept {
    state.mode = Mode::kFree;
    state.holdingCount = 0;
    state.ihip = ihip;
  }
  /// By a foot that is yet to be searched from.
  void setOneSurface(const ContactSurface& s, const ClosestPoint& closest, Vec3 ihip) noexcept {
    state.mode = Mode::kOneSurface;
    state.holdingCount = 1;
    state.holding[0] = s;
    state.feature = closest.feature;
    state.local = closest.point;
    state.ihip = ihip;
    foot = closest;
    footConverged = false;
  }
  void setSeveralSurfaces(std::span<const ContactSurface> surfaces) noexcept {
    state.mode = Mode::kSeveralSurfaces;
    state.holdingCount = static_cast<std::int32_t>(surfaces.size());
    std::copy(surfaces.begin(), surfaces.end(), state.holding.begin());
  }

  [[nodiscard]] Checkpoint checkpoint() const noexcept {
    return {state.mode, state.holdingCount, state.holding, state.feature, state.local, state.ihip, foot, footConverged};
  }
  void restore(const Checkpoint& before) noexcept {
    state.mode = before.mode;
    state.holdingCount = before.holdingCount;
    state.holding = before.holding;
    state.feature = before.feature;
    state.local = before.local;
    state.ihip = before.ihip;
    foot = before.foot;
    footConverged = before.footConverged;
  }

  const Corrections& corrections;
  std::span<const Body> bodies;
  ContactState& state;
  double stride;  ///< The fraction of the HIP's path and of the bodies' motions that this tick sets out to cover.
  Vec3 goal;      ///< The HIP, world: where its path leads.
  Vec3 hip;       ///< Where the covered path leads, world.
  NearBodies near;
  ContactWork work;
  ClosestPoint foot;           ///< kOneSurface: of the IHIP.
  bool footConverged = false;  ///< It is a local minimum of the distance to the HIP.
  bool settled = false;        ///< The IHIP has followed the surface that holds it, where that is deforming.
  double skin = 0;             ///< Metres, as the other two.
  double pathOffset = 0;
  double startOffset = 0;
};

}  // namespace haptics
