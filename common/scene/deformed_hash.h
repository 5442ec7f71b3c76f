#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/deform/dent.h"
#include "common/scene/scene.h"

namespace haptics {

/// The vertices of a mesh by its hash, null while they are not here.
using VerticesOf = std::function<const std::vector<Vec3f>*(const ContentHash& mesh)>;

/// SHA-256 over every vertex of every object that gives, where lattice and dents have it: (id, x, y, z ...), in order of id.
/// Each side computes it from what it holds; that they agree is the proof that they see the same shapes. Nothing while a
/// mesh is lacking.
[[nodiscard]] std::optional<ContentHash> deformedHash(const SceneVersion& scene, const VerticesOf& verticesOf,
                                                      std::span<const ObjectDent> dents);

}  // namespace haptics
