#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/hash/content_hash.h"

namespace haptics {

/// Bytes of an asset in one message: few messages for a large mesh, and each far below what NATS takes (1 MiB). Readers
/// compute with it, so another number is another protocol version.
inline constexpr std::size_t kPublishedChunk_bytes = 128U << 10;

/// The names of one published session's subjects and streams (audience.proto).
struct SessionSubjects {
  std::string snapshot, latest, commit, sample, relay;
  std::string live;          ///< Commits and samples.
  std::string audienceLive;  ///< The same, where who watches has an account apart (deploy/nats.conf).
  std::string sceneStream, assetStream;
  std::string assets;  ///< Of every chunk.

  /// Refused: a name that is not 1 to 32 letters, digits, - and _, or that ends in -assets.
  [[nodiscard]] static Result<SessionSubjects> of(std::string_view name);

  [[nodiscard]] std::string chunksOf(std::string_view assetInHex) const;
  [[nodiscard]] std::string chunk(const ContentHash& asset, std::uint64_t index) const;

 private:
  std::string root_;
};

}  // namespace haptics
