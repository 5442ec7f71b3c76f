#pragma once

#include <cstdint>
#include <string_view>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "haptics/v1/audience.pb.h"

// Messages as they come from NATS: whoever may publish there may send anything. Refused is what is larger than a frame of
// the protocol, does not parse, is of another version, or lacks what the reader computes with. Whether a scene is the
// server's is for its root to say.
namespace haptics {

[[nodiscard]] Result<v1::SnapshotPart> readSnapshotPart(std::string_view bytes);
[[nodiscard]] Result<v1::LatestSnapshot> readLatestSnapshot(std::string_view bytes);
[[nodiscard]] Result<v1::PublishedCommit> readPublishedCommit(std::string_view bytes);
[[nodiscard]] Result<v1::LiveMessage> readLiveMessage(std::string_view bytes);
/// Refused too: a chunk of another asset, or with another place or length than this index gives it.
[[nodiscard]] Result<v1::AssetChunk> readAssetChunk(std::string_view bytes, const ContentHash& asset,
                                                    std::uint64_t index);

}  // namespace haptics
