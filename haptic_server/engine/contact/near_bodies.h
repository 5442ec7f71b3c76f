#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/corrections.h"
#include "haptic_server/engine/contact/tolerances.h"

namespace haptics {

/// Finite, and within the range of the float vertices.
[[nodiscard]] inline bool isUsable(Vec3 hip) noexcept {
  constexpr double kFarthest = std::numeric_limits<float>::max();
  return std::abs(hip.x) <= kFarthest && std::abs(hip.y) <= kFarthest && std::abs(hip.z) <= kFarthest;  // not for NaN
}

/// Bodies that a tick can look at: all that a scene may have. More in reach at once are counted and the farthest left
/// out. Costs 150 bytes of stack each, of which only those are touched that are in reach.
inline constexpr int kMaxNear = 256;

/// How far from the HIP (world, metres) the IHIP can come in this tick: it never gets farther from the HIP than it is
/// now, so the ball about the HIP through the IHIP, widened by the HIP's own step, contains all. Moving bodies can push
/// it farther.
[[nodiscard]] double reachOf(const ContactState& state, Vec3 hip) noexcept;

/// Squared distance of the HIP (world, metres) to the body's box in its own frame, m^2; none when it is beyond `reach`.
[[nodiscard]] std::optional<double> squaredGap(const Body& body, Vec3 hip, double reach) noexcept;

/// A body that the IHIP, or a point of a tool, may come to in a tick.
struct NearBody {
  int body;
  bool pendingRemoval;
  const CollisionMesh* surface;
  Vec3 from;  // body frame, metres
  Frame frame;
};
static_assert(std::is_trivially_default_constructible_v<NearBody>, "a tick writes those alone that are in reach");

/// Of a segment from near.from to a place in that body's frame that passes beside a triangle (RimmedSegment): is there something
/// else beyond the gap, which the segment would enter two rims farther from the triangle's edge? Not what it enters where it is:
/// one that goes over the upper edge of a wall onto the top passes no gap.
/// @param entered  What it enters of that body by itself.
[[nodiscard]] bool isInGap(std::span<const NearBody> all, const NearBody& near, Vec3 to, const Crossing& rimmed,
                           const Crossing& entered, Allowance& allowance) noexcept;

/// The bodies within reach in a tick and, for each, the invariant of the contact core: `from` is the IHIP in the body's
/// own frame, and it advances only along segments that were tested against the body there. In every frame the IHIP thus
/// draws one continuous polyline that never enters; the motion of a body is part of its segment.
class NearBodies {
 public:
  using Near = NearBody;
  using Points = std::array<Vec3, kMaxNear>;  ///< One for each near body, in its frame; the rest is not written.
  struct Hit {
    int near = -1;
    Crossing crossing;

    explicit operator bool() const noexcept { return near >= 0; }
  };

  explicit NearBodies(Corrections::SegmentTest test = nullptr) noexcept : test_(test) {}

  /// Finds the bodies within reachOf(), widened by how far moving bodies can push.
  void gather(std::span<const Body> bodies, const ContactState& state, Vec3 hip, ContactWork& work) noexcept;

  [[nodiscard]] int count() const noexcept { return count_; }
  [[nodiscard]] double extent_m() const noexcept { return extent_; }  ///< Largest coordinate in reach.
  [[nodiscard]] Near& operator[](int i) noexcept { return near_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Near& operator[](int i) const noexcept { return near_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int indexOf(int body) const noexcept {
    for (int i = 0; i < count_; ++i) {
      if ((*this)[i].body == body) return i;
    }
    return -1;
  }

  /// Frames at fraction `time` of the tick.
  void setTime(std::span<const Body> bodies, double time) noexcept;
  [[nodiscard]] Points inEachFrame(Vec3 world) const noexcept;
  [[nodiscard]] Points from() const noexcept;
  /// The `from` of bodies whose vertices have moved goes with their surface.
  void shiftWithSurfaces(std::span<const Body> bodies) noexcept;
  /// Advances every `from` by the fraction `time` of its segment.
  void moveAll(const Points& to, double time) noexcept;

  /// Where the segment of the IHIP to a place in the body's frame enters it; `skip(triangle)` leaves out.
  template <class Skip>
  [[nodiscard]] Crossing crossing(const Near& near, Vec3 to, ContactWork& work, Skip skip) const noexcept {
    ++work.segments;
    const CollisionMesh& surface = *near.surface;
    if (test_ == nullptr && (count_ > 1 || !surface.closed() || surface.anySelfIntersecting())) {
      const double rim_m = kRim * surface.extent_m();
      const Crossing rimmed =
          surface.firstCrossing<RimmedSegment>(near.from, to, !surface.closed(), work.allowance, skip, rim_m);
      return rimmed.isBeside ? inGapOrEntered(near, to, rimmed, work, skip) : rimmed;
    }
    if (test_ != nullptr) [[unlikely]]
      return surface.firstCrossing<AblatedSegment>(near.from, to, !surface.closed(), work.allowance, skip, test_);
    return surface.firstCrossing(near.from, to, !surface.closed(), work.allowance, skip);
  }
  [[nodiscard]] Crossing crossing(const Near& near, Vec3 to, ContactWork& work) const noexcept {
    return crossing(near, to, work, [](std::uint32_t) noexcept { return false; });
  }
  /// The earliest crossing on from -> to over all near bodies; `skip(near index, triangle)` leaves out. Means nothing
  /// once the allowance is spent.
  template <class Skip>
  [[nodiscard]] Hit firstHit(const Points& to, Skip skip, ContactWork& work) const noexcept {
    Hit hit;
    work.allowance.spend(Allowance::kPlace * count_);  // for their places in each frame
    for (int i = 0; i < count_ && !work.allowance.isSpent(); ++i) {
      const Crossing crossing = this->crossing((*this)[i], to[static_cast<std::size_t>(i)], work,
                                               [&](std::uint32_t t) noexcept { return skip(i, t); });
      if (crossing && (!hit || crossing.time < hit.crossing.time)) hit = {i, crossing};
    }
    return hit;
  }

 private:
  /// Takes the place of Segment.
  struct AblatedSegment {
    Vec3 from;
    Vec3 to;
    Corrections::SegmentTest test;

    [[nodiscard]] bool enters(const TriangleRecord& record, bool twoSided, Crossing& crossing) const noexcept {
      return test(from, to, record, twoSided, crossing);
    }
  };

  template <class Skip>
  [[nodiscard, gnu::noinline]] Crossing inGapOrEntered(const Near& near, Vec3 to, const Crossing& rimmed,
                                                       ContactWork& work, Skip skip) const noexcept {
    const Crossing entered = near.surface->firstCrossing(near.from, to, !near.surface->closed(), work.allowance, skip);
    return isInGap({near_.data(), static_cast<std::size_t>(count_)}, near, to, rimmed, entered, work.allowance)
               ? rimmed
               : entered;
  }

  void admit(const Body& body, int index, double gap, ContactWork& work) noexcept;
  std::array<Near, kMaxNear> near_;   // those beyond the count are not written
  std::array<double, kMaxNear> gap_;  // m^2 from the HIP to the box; -1 for a body that holds the IHIP
  int count_ = 0;
  double extent_ = 0;
  Corrections::SegmentTest test_;
};

}  // namespace haptics
