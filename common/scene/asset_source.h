#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/hash/content_hash.h"

namespace haptics {

/// What is named by its content and travels apart from the records. Numbered as on the wire.
enum class AssetKind : std::uint8_t {
  kMesh = 1,
  kScalarField = 3,
  kVertexValues = 4,
  kMovedVertices = 5,
  kPointField = 6
};

/// Of the files that hold the canonical bytes of such assets.
[[nodiscard]] constexpr std::string_view fileEndingOf(AssetKind kind) noexcept {
  switch (kind) {
    case AssetKind::kMesh:
      return ".mesh";
    case AssetKind::kScalarField:
      return ".field";
    case AssetKind::kVertexValues:
      return ".values";
    case AssetKind::kMovedVertices:
      return ".moved";
    case AssetKind::kPointField:
      return ".points";
  }
  return "";
}

struct AssetName {
  AssetKind kind = AssetKind::kMesh;
  ContentHash hash;
  auto operator<=>(const AssetName&) const = default;
};

// ---- Where an edit says that an asset comes from ----

struct FileSource {
  std::string path;
};  ///< Relative, below an asset folder.
struct AssetSource {
  ContentHash hash;
};  ///< One that the server holds.

}  // namespace haptics
