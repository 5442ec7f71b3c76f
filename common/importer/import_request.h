#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>

#include "common/importer/mesh_recipe.h"
#include "common/mesh/import.h"
#include "common/scene/surface_edits.h"

// What is said between importer.h and the programs asset_importer, inventor_importer and assimp_importer, over a socket: values as they lie in memory, for both
// are of one build.
namespace haptics {

struct MeshFileRequest {
  MeshFormat format = MeshFormat::kObj;
  ImportOptions options;
};
struct ImageRequest {};
/// The descriptor is of a mesh's canonical bytes.
struct GrownRequest {
  GrownReactionDiffusionSource recipe;
};

/// Goes first. With the file's descriptor, where it is of a file.
using ImportRequest = std::variant<MeshFileRequest, ImageRequest, MeshRecipe, ReactionDiffusionSource, GrownRequest>;
static_assert(std::is_trivially_copyable_v<ImportRequest>);

/// The importer's messages: any number of names of files that the file includes, each answered with an IncludeReply, then an
/// error or what was asked for.
struct ImporterMessage {
  enum class Kind : std::uint32_t {
    kInclude = 1,  ///< A name follows.
    kRefused,      ///< The error's field, a zero byte and its reason follow.
    kDone          ///< Canonical bytes follow.
  };
  Kind kind = Kind::kDone;
  std::uint64_t size = 0;  ///< Bytes that follow.
  MeshReport report;       ///< Of a mesh from a file.
};
static_assert(std::is_trivially_copyable_v<ImporterMessage>);

/// With the file's descriptor when it is there and may be read.
enum class IncludeReply : std::uint8_t { kNo = 0, kYes = 1 };

inline constexpr std::size_t kLongestInclude = 4096;  ///< Bytes of a name.
inline constexpr std::size_t kLongestRefusal = 4096;  ///< Bytes, of field and reason together.

/// Processor time that one import may take, seconds: a soup of 60,000 triangles that all cross each other takes 120.
inline constexpr unsigned kMaxImportTime_s = 300;

}  // namespace haptics
