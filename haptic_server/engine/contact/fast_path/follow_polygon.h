#pragma once

#include <array>
#include <span>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/engine/contact/near_bodies.h"

// Inline, as a call would take longer than it saves.

namespace haptics {

/// The bodies that NearBodies::gather() would find beside the held one.
struct NearbyBodies {
  std::array<const Body*, kMaxNear - 1> body;
  std::size_t count = 0;

  [[nodiscard]] std::span<const Body* const> all() const noexcept { return std::span(body).first(count); }
};

/// Axes and origin of a Frame, to turn and carry with its operations.
struct WideFrame {
  Double4 x, y, z, origin;

  explicit WideFrame(const Frame& f) noexcept
      : x(toDouble4(f.x)), y(toDouble4(f.y)), z(toDouble4(f.z)), origin(toDouble4(f.origin)) {}
  [[nodiscard]] Double4 rotate(Double4 local) const noexcept {
    return x * broadcastLane<0>(local) + y * broadcastLane<1>(local) + z * broadcastLane<2>(local);
  }
};

/// Where the neighborhood watch ends.
struct Minimum {
  std::uint32_t triangle;
  Feature feature;
  Double4 foot;
  Double4 normal;
};

/// Stores a tick over one surface. Each value is a store of its own: where values are put together in memory and taken
/// out again in larger pieces, the processor waits for every store.
[[gnu::always_inline]] inline void storeContact(const Body& body, ContactState& state, const Vec3& hip,
                                                const Minimum& minimum, ContactResult& result) noexcept {
  const WideFrame frame(body.frame);
  const Vec3 ihip = vec3(frame.rotate(minimum.foot) + frame.origin);
  ContactSurface& holding = state.holding[0];
  result.touching = true;
  result.body = holding.body;
  result.ihip = ihip;
  result.normal = vec3(frame.rotate(minimum.normal * broadcast(holding.side)));
  holding.triangle = minimum.triangle;
  state.feature = minimum.feature;
  state.local = vec3(minimum.foot);
  state.ihip = ihip;
  state.hip = hip;
}

/// Of a tick that ends beyond the polygon, at `beyond`: from polygon to polygon, as followOverPolygons() does. False
/// when the general tick has to decide.
[[nodiscard]] bool stepOverTriangles(const Body& body, ContactState& state, const CachedTriangle& polygon,
                                     const Vec3& hip, const Vec3& h, const Prism::Coordinates& beyond,
                                     ContactResult& result, ContactCache& cache) noexcept;
/// Is the way to a foot on the held polygon clear of the others?
[[nodiscard]] bool footIsClear(const Body& body, const NearbyBodies& others, const ContactState& state,
                               const Vec3& foot, ContactWork& work) noexcept;

/// A tick that ends over the polygon, at `end`, and inside of the surface.
[[gnu::always_inline]] inline void finishOnTriangle(const Body& body, ContactState& state,
                                                    const CachedTriangle& polygon, const Vec3& hip, const Vec3& h,
                                                    const Prism::Coordinates& end, int looked,
                                                    ContactResult& result) noexcept {
  result.work.triangles = looked;
  result.work.steps = 1;
  result.primitive = {PrimitiveKind::kPolygon, 0, polygon.canonical};
  const Double4 foot = polygon.foot(toDouble4(h), end.height());
  result.alongNormal = true;
  result.penetration_m = polygon.distance(end.height());
  storeContact(body, state, hip, {polygon.triangle, Feature::kPolygon, foot, polygon.unitNormal}, result);
}

/// From a polygon to where the HIP is above it, or, without `others`, above polygons beyond. False when the general
/// tick has to decide.
[[nodiscard, gnu::always_inline]] inline bool followOnTriangle(const Body& body, ContactState& state,
                                                               const CachedTriangle& polygon, const Vec3& hip,
                                                               ContactResult& result, ContactCache& cache,
                                                               const NearbyBodies* others) noexcept {
  const Vec3 h = body.frame.toLocal(hip);
  const Prism::Coordinates end = polygon.prism.coordinates(broadcast(h));
  if (end.beyond() != 0) [[unlikely]] {
    const Vec3 place = h;  // copies, so that the others stay in registers
    const Prism::Coordinates beyond = end;
    return others == nullptr && stepOverTriangles(body, state, polygon, hip, place, beyond, result, cache);
  }
  if (end.isOutside(state.holding[0].side)) [[unlikely]]
    return false;
  if (others != nullptr) {
    const Vec3 foot = vec3(polygon.foot(toDouble4(h), end.height()));
    if (!footIsClear(body, *others, state, foot, result.work)) return false;
  }
  finishOnTriangle(body, state, polygon, hip, h, end, 1, result);
  return true;
}

/// Puts the polygon that holds the contact into the cache. False where a body has to be looked at as a whole.
[[nodiscard]] bool loadHeld(const Body& body, const ContactState& state, ContactCache& cache) noexcept;

/// The most common tick: one body, at rest, whose polygon holds the IHIP. False, and nothing written but to the cache and
/// the allowance, when there is more to it. Of a HIP that is usable.
[[nodiscard, gnu::always_inline]] inline bool stayOnPolygon(std::span<const Body> bodies, ContactState& state,
                                                            const Vec3& hip, ContactResult& result,
                                                            ContactCache& cache) noexcept {
  if (bodies.size() != 1 || state.feature != Feature::kPolygon || state.unfinished) return false;
  const ContactSurface& holding = state.holding[0];
  const Body& body = bodies.front();
  if (body.moving) return false;
  const CachedTriangle* polygon = &cache.polygon;
  if (!polygon->is(*body.surface, holding.triangle)) {
    polygon = cache.ahead != nullptr ? cache.ahead->find(*body.surface, holding.triangle) : nullptr;
    if (polygon == nullptr) {
      if (!loadHeld(body, state, cache)) return false;
      polygon = &cache.polygon;
    }
  }
  return followOnTriangle(body, state, *polygon, hip, result, cache, nullptr);
}

}  // namespace haptics
