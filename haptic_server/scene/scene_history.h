#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/scene/scene.h"
#include "haptic_server/scene/recent_edits.h"

namespace haptics {

/// Edits kept for clients that reconnect. A client farther behind gets a snapshot.
inline constexpr std::size_t kRememberedEdits = 1024;

/// One immutable revision of the scene with the edits that led to it, shared with the network thread.
struct SceneHistory {
  std::uint64_t epoch = 0;  ///< Random; another one means that the server lost its state.
  SceneVersion version;
  RecentEdits edits;  ///< The last of them, oldest first, up to `version`.

  /// Takes over an edit and the version it made; lets edits go that are older than the last `remembered`.
  void append(std::shared_ptr<const AcceptedEdit> edit, SceneVersion made, std::size_t remembered = kRememberedEdits);
  /// The edit that made this revision; null when it is not remembered.
  [[nodiscard]] std::shared_ptr<const AcceptedEdit> find(std::uint64_t revision) const;
  /// Nothing when the revision is older than what is remembered, or not made yet.
  [[nodiscard]] std::optional<ContentHash> rootAt(std::uint64_t revision) const;
  /// Whether one who holds this state becomes equal to `version` by applying remembered edits.
  [[nodiscard]] bool canResumeFrom(std::uint64_t itsEpoch, std::uint64_t revision, const ContentHash& root) const;
};

/// At random, never 0: that is the epoch of a client that holds nothing.
[[nodiscard]] std::uint64_t newEpoch();

}  // namespace haptics
