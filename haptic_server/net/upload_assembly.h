#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/scene/asset_source.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Largest asset that a client may send, in canonical bytes: a mesh of about 14 million triangles.
inline constexpr std::uint64_t kMaxUploadBytes = 256U << 20;

/// Puts one upload's chunks together. An asset that was refused is refused once: the chunks of it that are already
/// under way are ignored until it is begun again.
class UploadAssembly {
 public:
  explicit UploadAssembly(std::size_t chunk_bytes) noexcept : chunk_bytes_(chunk_bytes) {}

  /// Checks a chunk on its own and against what came before. A chunk at offset 0 begins a new upload and drops an
  /// unfinished one. Errors name the field below AssetUpload.
  [[nodiscard]] Result<void> check(const v1::AssetChunk& chunk, const AssetName& name) const;
  [[nodiscard]] bool assembles(const ContentHash& hash) const noexcept { return total_ != 0 && name_.hash == hash; }
  [[nodiscard]] bool ignores(const v1::AssetChunk& chunk, const ContentHash& hash) const;
  void add(const v1::AssetChunk& chunk, const AssetName& name);  ///< Takes a checked chunk's bytes.
  void abandon(const ContentHash& hash);  ///< Ends the upload; chunks of this asset are ignored from now on.

  [[nodiscard]] std::optional<ContentHash> assembled() const noexcept {  ///< Which is under way.
    return total_ == 0 ? std::nullopt : std::optional(name_.hash);
  }
  [[nodiscard]] bool complete() const noexcept { return total_ != 0 && bytes_.size() == total_; }
  [[nodiscard]] std::string take();  ///< The complete upload's bytes; none is under way afterwards.

 private:
  std::size_t chunk_bytes_;
  AssetName name_;
  std::uint64_t total_ = 0;
  std::string bytes_;
  std::optional<ContentHash> ignored_;
};

}  // namespace haptics
