#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/deform/falloff.h"
#include "common/deform/narrowed.h"
#include "common/maths/vec.h"

namespace haptics {

/// A dent in a soft object: what moves its vertices. Object frame, metres. Single precision, because these numbers go over
/// the wire: both sides compute with the same ones.
struct Dent {
  Vec3f centre{0};        ///< On the surface as the dents before it have it.
  Vec3f displacement{0};  ///< Of the centre: along IHIP to HIP.

  bool operator==(const Dent&) const = default;
  HAPTICS_FIELDS(self.centre, self.displacement);
};

/// Dents of a scene at once: the contact's own, and those that are going back. More would make samples larger than a
/// datagram.
inline constexpr std::size_t kMaxDents = 6;
/// Dents of both hands at once.
inline constexpr std::size_t kMaxDentsOfAll = 2 * kMaxDents;

/// One of them, and the object that it is in.
struct ObjectDent {
  std::uint64_t object = 0;
  Dent dent;

  bool operator==(const ObjectDent&) const = default;
};

/// Displacement of a point of the object by this dent; the point as the dents before this one have it. Metres.
[[nodiscard]] inline Vec3 displacementBy(const Dent& dent, const Falloff& falloff, Vec3 rest) noexcept {
  return Vec3(dent.displacement) * falloff.at(rest - Vec3(dent.centre));
}

/// A vertex with one more dent, of which it has this part. Exactly as it was where that is nothing.
[[nodiscard]] inline Vec3f dentedBy(const Dent& dent, Vec3f rest, double part) noexcept {
  const Vec3 way = Vec3(dent.displacement) * part;
  return way.x == 0 && way.y == 0 && way.z == 0 ? rest : narrowed(Vec3(rest) + way);
}

/// A vertex of an object with these dents. Paper 5 (d): "The vertices of the 3-D object that are in the close vicinity of
/// the IHIP are moved, along the vector from IHIP to HIP, using a simple polynomial function". One function for both
/// processes. The dents come one after another, each rounded as a vertex is: where the first of them become the shape at
/// rest, the others go on from there bit-identically. (Summed, they would also turn one another inside out.)
[[nodiscard]] inline Vec3f dented(Vec3f rest, std::span<const Dent> dents, const Falloff& falloff) noexcept {
  for (const Dent& dent : dents) rest = dentedBy(dent, rest, falloff.at(Vec3(rest) - Vec3(dent.centre)));
  return rest;
}

/// A vertex and the normal there, which need not be of unit length.
struct VertexWithNormal {
  Vec3f place{0};
  Vec3 normal{0};
};

/// The same with the normal: as at rest, turned by the inverse transpose of the displacements' Jacobian,
/// I + displacement (grad falloff)^T for each dent. One function for both processes.
[[nodiscard]] inline VertexWithNormal dented(VertexWithNormal vertex, std::span<const Dent> dents,
                                             const Falloff& falloff) noexcept {
  for (const Dent& dent : dents) {
    const Vec3 way(dent.displacement);
    const Falloff::Slope slope = falloff.slopeAt(Vec3(vertex.place) - Vec3(dent.centre));
    vertex.place = dentedBy(dent, vertex.place, slope.value);
    const double turn = glm::dot(way, vertex.normal) / (1 + glm::dot(slope.gradient, way));  // Sherman and Morrison
    vertex.normal -= slope.gradient * turn;
  }
  return vertex;
}

/// How much a dent may displace, what stays of plastic ones altogether, and those that are going back together with the
/// contact's. The displacement changes by no more than this fraction of the distance between two places, so that the
/// deformation is one to one, and no triangle turns over unless one of its angles is larger than 120 degrees. Larger lets a
/// soft object yield farther before it turns hard; 1 turns it inside out.
inline constexpr double kMaxDentGradient = 0.5;

/// The lengths of an object's displacements, summed, stay within this.
[[nodiscard]] inline double maxDentDepth_m(const Falloff& falloff) noexcept {
  return kMaxDentGradient / falloff.maxSlope_per_m();
}

}  // namespace haptics
