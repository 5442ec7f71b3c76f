#include "common/scene/deformation_properties.h"

#include <algorithm>

#include "common/deform/free_form.h"
#include "common/interruption/grow.h"

namespace haptics {
namespace {

/// Before each in an object's hash, after those of its surface and motion.
constexpr std::uint64_t kSoftness = 5;
constexpr std::uint64_t kLattice = 6;
constexpr std::uint64_t kResidue = 7;
constexpr std::uint64_t kPlastic = 8;  // only where there is some: older records hash as they did

}  // namespace

DeformationProperties edited(DeformationProperties properties, const DeformationEdit& edit) {
  if (edit.softness) properties.softness = *edit.softness;
  if (edit.lattice) {
    properties.lattice = *edit.lattice;
    properties.residue.reset();
  }
  if (!edit.residue) return properties;
  properties.residue.reset();
  if (const auto& given = *edit.residue) {
    const auto* asset = std::get_if<AssetSource>(&*given);
    properties.residue = asset != nullptr ? asset->hash : ContentHash{};
  }
  return properties;
}

SoftTissue tissueOf(const Softness& softness) {
  return {Falloff(softness.radius_m, softness.degree), softness.stiffness_N_per_m, softness.return_s, softness.plastic};
}

std::vector<Vec3f> shapedBy(const Lattice& lattice, std::span<const Vec3f> vertices) {
  const FreeForm shape(lattice.low_m, lattice.size_m, lattice.points, lattice.control_m);
  std::vector<Vec3f> shaped(vertices.size());
  forEach(vertices.size(), [&](std::size_t i) { shaped[i] = shape(vertices[i]); });
  return shaped;
}

std::vector<Vec3f> shapeAtRest(const DeformationProperties& properties, std::span<const Vec3f> vertices,
                               const MovedVertices* residue) {
  std::vector<Vec3f> shape = properties.lattice ? shapedBy(*properties.lattice, vertices)
                                                : std::vector<Vec3f>(vertices.begin(), vertices.end());
  if (residue != nullptr) residue->moveIn(shape);
  return shape;
}

void addTo(Hasher& h, const DeformationProperties& p) {
  if (p.softness) {
    h.add(kSoftness).add(p.softness->stiffness_N_per_m).add(p.softness->radius_m);
    h.add(std::uint64_t{p.softness->degree}).add(p.softness->return_s);
    if (p.softness->plastic > 0) h.add(kPlastic).add(p.softness->plastic);
  }
  if (p.lattice) {
    h.add(kLattice);
    h.add(p.lattice->low_m);
    h.add(p.lattice->size_m);
    for (const std::uint32_t count : p.lattice->points) h.add(std::uint64_t{count});
    for (const Vec3f point : p.lattice->control_m) h.add(point.x).add(point.y).add(point.z);
  }
  if (p.residue) h.add(kResidue).add(*p.residue);
}

}  // namespace haptics
