#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "common/deform/soft_tissue.h"
#include "common/hash/content_hash.h"
#include "common/maths/vec.h"
#include "common/mesh/moved_vertices.h"
#include "common/scene/asset_source.h"

// How an object yields, and what deforms it, as both databases hold it. SI units, object frame.
namespace haptics {

/// Yields to the contact (common/deform/soft_tissue.h).
struct Softness {
  double stiffness_N_per_m = 0;  ///< Of the tissue, in series with the material's. > 0.
  double radius_m = 0;           ///< Of a dent's falloff. > 0.
  std::uint32_t degree = 2;      ///< Of a dent's falloff.
  double return_s = 0;           ///< Time constant with which dents go back; 0: elastic.
  double plastic = 0;            ///< The part of a dent that stays, 0 to 1.
  bool operator==(const Softness&) const = default;
};

/// A free-form deformation (common/deform/free_form.h): where the control points of a lattice around the mesh are.
struct Lattice {
  Vec3 low_m{0};                          ///< Corner of the box that the lattice fills at rest.
  Vec3 size_m{0};                         ///< Sides of the box, each > 0. The mesh lies within it.
  std::array<std::uint32_t, 3> points{};  ///< Along x, y and z; each 2 to 8.
  std::vector<Vec3f> control_m;           ///< One for each, x fastest; finite.
  bool operator==(const Lattice&) const = default;
};

struct DeformationProperties {
  std::optional<Softness> softness;
  std::optional<Lattice> lattice;
  std::optional<ContentHash> residue = std::nullopt;  ///< Moved vertices that plastic dents have left.
  bool operator==(const DeformationProperties&) const = default;
  [[nodiscard]] bool empty() const noexcept { return !softness && !lattice && !residue; }
};

using ResidueSource = std::variant<AssetSource, FileSource>;

/// As an edit asks for it: each is kept where nothing is said of it, and taken away where it is given as nothing.
struct DeformationEdit {
  std::optional<std::optional<Softness>> softness;
  std::optional<std::optional<Lattice>> lattice;
  bool latticeOfMesh = false;  ///< The lattice's box is to be that of the mesh.
  std::optional<std::optional<ResidueSource>> residue = std::nullopt;
  [[nodiscard]] bool empty() const noexcept { return !softness && !lattice && !residue; }
};

/// A residue is of the shape that it was left on: another lattice takes it away, unless a new one is given with it. Its hash is
/// zero until its file has been read.
[[nodiscard]] DeformationProperties edited(DeformationProperties properties, const DeformationEdit& edit);

[[nodiscard]] SoftTissue tissueOf(const Softness& softness);
/// A mesh's vertices as the lattice has them.
[[nodiscard]] std::vector<Vec3f> shapedBy(const Lattice& lattice, std::span<const Vec3f> vertices);

/// A mesh's vertices at rest: as lattice and residue have them, before any dents.
/// @param residue  The properties', or null while it is not here.
[[nodiscard]] std::vector<Vec3f> shapeAtRest(const DeformationProperties& properties, std::span<const Vec3f> vertices,
                                             const MovedVertices* residue);

/// In canonical form, each after its number; nothing for an object without any.
void addTo(Hasher& hasher, const DeformationProperties& properties);

}  // namespace haptics
