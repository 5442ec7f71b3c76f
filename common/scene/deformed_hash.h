#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/deform/dent.h"
#include "common/scene/scene.h"

namespace haptics {

/// What a client or a server holds of the shapes of its objects, by hash; each is null while it is not here.
struct HeldShapes {
  std::function<const std::vector<Vec3f>*(const ContentHash& mesh)> vertices;
  std::function<const MovedVertices*(const ContentHash& residue)> residue;
};

/// SHA-256 over every vertex of every object that gives, where lattice, residue and dents have it: (id, x, y, z ...), in
/// order of id. Each side computes it from what it holds; that they agree is the proof that they see the same shapes.
/// Nothing while a mesh or a residue is lacking.
[[nodiscard]] std::optional<ContentHash> deformedHash(const SceneVersion& scene, const HeldShapes& held,
                                                      std::span<const ObjectDent> dents);

}  // namespace haptics
