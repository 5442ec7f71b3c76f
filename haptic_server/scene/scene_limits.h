#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// What whoever may edit cannot exceed. Other values than these are for tests.
struct SceneLimits {
  /// Canonical bytes of all assets together: 28 million triangles, of which the server makes some 4 GB.
  std::size_t assets_bytes = 512U << 20;
  /// Size of all objects' details (detailSizeOf): a snapshot then fits what a connection takes at once.
  std::size_t details_bytes = 2U << 20;
  /// On the wire, of the objects that one edit changes and removes and of its reports: its commit and the answer to it
  /// then fit one frame each.
  std::size_t answer_bytes = 1'000'000;
  /// Of all objects whose vertices are driven: mostDrivenTriangles().
  std::size_t driven_triangles = 20'000;
  /// For clients that reconnect; one that is farther behind gets a snapshot.
  std::size_t remembered_edits = kRememberedEdits;
};

/// What of an object grows, about as it is on the wire: Fourier terms, layers, creases, the control points of a lattice, an
/// effect's path.
[[nodiscard]] std::size_t detailSizeOf(const ObjectRecord& record);

/// On the wire, of what SceneLimits::answer_bytes bounds.
[[nodiscard]] std::size_t answerSizeOf(const Commit& commit, const std::vector<std::string>& reports);

/// Bytes of memory that a decoded edit takes, allocators' overhead aside.
[[nodiscard]] std::size_t memoryOf_bytes(const Transaction& transaction) noexcept;

}  // namespace haptics
