#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/engine/contact/body.h"

namespace haptics {

struct ContactCache;

/// A surface that holds the IHIP.
struct ContactSurface {
  int body = -1;               ///< Index into bodies.
  int side = 1;                ///< 1 the outside, -1 the back of a sheet.
  std::uint32_t triangle = 0;  ///< In the body's mesh.

  HAPTICS_FIELDS(self.body, self.side, self.triangle);
};

/// A ball in which a free HIP meets nothing.
struct Clearance {
  Vec3 centre{0};               ///< World.
  double radius_m = 0;          ///< 0: not known.
  std::uint32_t pause = 0;      ///< Ticks until the next search for it.
  std::uint32_t lastPause = 0;  ///< What `pause` was set to after the last search in vain.

  HAPTICS_FIELDS(self.centre, self.radius_m, self.pause, self.lastPause);
};

/// All that the contact core remembers from tick to tick. Written by resetContact(), releaseContact(), followContact()
/// and reprojectContact() only.
struct ContactState {
  enum class Mode : std::uint8_t { kFree, kOneSurface, kSeveralSurfaces };
  friend constexpr Mode lastOf(Mode) noexcept { return Mode::kSeveralSurfaces; }
  static constexpr int kMaxHolding = 3;  ///< Three surfaces hold a point.

  Word<Mode> mode = Mode::kFree;
  /// kOneSurface: the primitive that holds the IHIP, the triangle itself, one of its lines or vertices.
  Word<Feature> feature = Feature::kPolygon;
  Word<bool> reprojected = false;  ///< By an adoption since the last tick.
  /// The last tick had no allowance left to see whether the IHIP is inside of a body.
  Word<bool> containmentUnchecked = false;
  /// Of the three `containmentUnchecked`, `reached < 1` and `stride < 1`, is there one? The fast path makes one
  /// comparison of it.
  Word<bool> unfinished = false;
  /// Unless free, the first one is that to which the contact belongs.
  std::array<ContactSurface, kMaxHolding> holding;
  /// kOneSurface: 1. kSeveralSurfaces: those that push, the strongest first; 0 while it settles.
  std::int32_t holdingCount = 0;
  Vec3 hip{0};    ///< World, of the last tick.
  Vec3 ihip{0};   ///< World, of the last tick; also when free.
  Vec3 local{0};  ///< kOneSurface: the IHIP in the body's frame; it is carried with the body.
  /// The fraction of the HIP's path and of the bodies' motions that the last tick covered: less than 1 when it spent
  /// its allowance. `hip` and `ihip` are of that time, and so have the bodies' previous poses to be in the next tick.
  double reached = 1;
  /// The fraction of its path that a tick sets out to cover: less than 1 after one that could not make a step.
  double stride = 1;
  Clearance clear;  ///< Free.

  HAPTICS_FIELDS(self.mode, self.feature, self.reprojected, self.containmentUnchecked, self.unfinished, self.holding,
                 self.holdingCount, self.hip, self.ihip, self.local, self.reached, self.stride, self.clear);

  /// The surfaces that the contact involves: none when free, else at least the first.
  [[nodiscard]] std::span<const ContactSurface> surfaces() const noexcept {
    const auto count = static_cast<std::size_t>(holdingCount > 1 ? holdingCount : 1);
    return std::span(holding).first(mode == Mode::kFree ? 0 : count);
  }
  [[nodiscard]] bool holds(int body) const noexcept {
    return std::ranges::find(surfaces(), body, &ContactSurface::body) != surfaces().end();
  }
};
static_assert(std::is_trivially_copyable_v<ContactState> && fields::isListed<ContactState>());

/// What a tick cost, in primitives, and whether it met a limit. Counted, never silent.
struct ContactWork {
  int triangles = 0;            ///< Looked at by the searches.
  int segments = 0;             ///< Tested against a whole body.
  int steps = 0;                ///< Into which the HIP's motion was divided.
  int solverRounds = 0;         ///< Of the constraint solver.
  int droppedBodies = 0;        ///< Bodies in reach beyond kMaxNear, left out: the farthest ones.
  bool interrupted = false;     ///< A search ran out of budget; it goes on from the best IHIP in the next tick.
  bool notConverged = false;    ///< The solver ran out of rounds or planes; it goes on in the next tick.
  bool allowanceSpent = false;  ///< The allowance was spent: the rest of the HIP's path comes with the next tick.
  bool depenetrated = false;    ///< The IHIP was found inside a body and put outside of all: the force may jump.
  int insideOf = -1;            ///< Index into bodies of that body, or of the sheet that it was behind.
  Allowance allowance;          ///< What is left of it.
};

/// What the contact core found: the rest of the step reads only this.
struct ContactResult {
  bool touching = false;
  int body = -1;             ///< Index into bodies, -1 when free.
  Vec3 ihip{0};              ///< World; equals the HIP when free.
  Vec3 normal{0};            ///< World, unit, outward: of the contacted primitive, or towards the IHIP when several
                             ///< surfaces hold it; zero when free.
  double penetration_m = 0;  ///< |IHIP - HIP|, 0 when free.
  bool alongNormal = false;  ///< The normal is the direction from the HIP to the IHIP: a polygon holds it.
  PrimitiveId primitive;     ///< Canonical numbering.
  /// Triangle of the body's mesh, where dents have moved the IHIP there or let it be met there; else that of the
  /// surface that holds it.
  std::uint32_t triangle = kNoTriangle;
  ContactWork work;
};

/// The primitive that holds the foot, in canonical numbering.
[[nodiscard]] inline PrimitiveId primitiveOf(const CollisionMesh& surface, const ClosestPoint& foot) noexcept {
  static_assert(static_cast<int>(PrimitiveKind::kPolygon) == static_cast<int>(Feature::kPolygon) + 1);
  static_assert(static_cast<int>(PrimitiveKind::kVertex) == static_cast<int>(Feature::kVertex) + 1);
  const auto kind = static_cast<PrimitiveKind>(static_cast<int>(foot.feature) + 1);
  return {kind, foot.index, surface.canonical(foot.triangle)};
}

/// Feature type of a primitive.
[[nodiscard]] inline Feature featureOf(const PrimitiveId& primitive) noexcept {
  return static_cast<Feature>(static_cast<int>(primitive.kind) - 1);
}

/// Free at hip (world): attach, re-attach.
void resetContact(ContactState& state, Vec3 hip) noexcept;

/// Frees the IHIP where it is: the next followContact() finds the surfaces that hold it between there and the HIP.
void releaseContact(ContactState& state) noexcept;

/// One tick (paper 3.2): the path of the HIP from its last place to `hip` (world), the IHIP on the surfaces that it
/// meets. Neither allocates nor locks. A HIP that is not finite, or beyond the range of the float vertices, counts as
/// one that did not move.
///
/// Bounded by result.work.allowance. A tick that spends it ends with the last step that was made before: every piece of
/// the IHIP's path was tested, and ContactState::reached is the fraction of the HIP's path that this covers. So the
/// IHIP passes dense places more slowly than the HIP moves, and never passes anything untested.
///
/// @param cache  Of this contact, which saves time alone.
[[nodiscard]] ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip,
                                          ContactCache& cache) noexcept;
/// The same into a `result` as constructed, but for its allowance: returning a copy of it would cost time.
void followContact(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   ContactCache& cache) noexcept;

/// The origin of a body of an adopted scene.
struct BodyOrigin {
  int before = -1;      ///< Its index in the bodies before the adoption, -1 when it is new.
  bool changed = true;  ///< Its surface or its pose is another one (or it is new).
  /// And that only for dents which the contact was felt in already: the same triangles, their vertices displaced.
  bool dented = false;
};

/// Times that a proxy that was pushed out of one body is tested against the others.
inline constexpr int kMaxReprojectionRounds = 8;

/// Carries the state over an adoption; `origins[i]` is that of `bodies[i]`. The caller clears its ContactCache. Contact
/// with unchanged bodies goes on as it was; with a single surface that is only dented it goes on from the same
/// triangle, or ends where that lets the HIP out. Otherwise the proxy (IHIP) stays where it is in the world, is pushed
/// out of every changed closed body that it is inside of, and the next followContact() finds the surfaces that hold it.
/// Returns true when the contact could not be carried as it was, that is when the force may jump: the caller slews
/// that. Bounded by kMaxReprojectionRounds closest point queries per body, and by the allowance; where that ends it,
/// the next tick looks whether the IHIP is inside of a body.
[[nodiscard]] bool reprojectContact(ContactState& state, std::span<const Body> bodies,
                                    std::span<const BodyOrigin> origins, Allowance allowance = {}) noexcept;

}  // namespace haptics
