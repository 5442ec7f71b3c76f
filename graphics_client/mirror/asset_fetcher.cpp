#include "graphics_client/mirror/asset_fetcher.h"

#include <algorithm>

#include "common/mesh/tri_mesh.h"

namespace haptics {
namespace {

/// Nothing larger is an asset; the largest is a mesh (mesh_asset.h): header, three floats a vertex, three indices a
/// triangle. Memory is taken as bytes arrive, whatever size was declared.
constexpr std::uint64_t kMaxAssetBytes = 24 + 12 * kMaxVertices + 12 * kMaxTriangles;

auto chunkRefused(const ContentHash& hash, const char* field, const std::string& reason) {
  return refused("asset_chunk." + std::string(field), reason + " (asset " + hash.hex() + ")");
}

}  // namespace

void AssetFetcher::want(const std::vector<AssetName>& lacking) {
  std::erase_if(transfers_, [&](const auto& entry) {
    return std::ranges::count(lacking, AssetName{entry.second.kind, entry.first}) == 0;
  });
  for (const AssetName& asset : lacking) transfers_.try_emplace(asset.hash, Transfer{.kind = asset.kind});
}

std::optional<v1::AssetRequest> AssetFetcher::next() {
  const auto inFlight =
      std::ranges::count_if(transfers_, [](const auto& entry) { return entry.second.phase == Phase::kRequested; });
  const auto waiting =
      std::ranges::find_if(transfers_, [](const auto& entry) { return entry.second.phase == Phase::kWaiting; });
  if (waiting == transfers_.end() || static_cast<std::size_t>(inFlight) >= kMaxInFlight) return std::nullopt;
  waiting->second.phase = Phase::kRequested;
  v1::AssetRequest request;
  request.set_hash(waiting->first.asBytes());
  request.set_offset(waiting->second.bytes.size());
  return request;
}

Result<std::optional<AssetFetcher::Asset>> AssetFetcher::take(const v1::AssetChunk& chunk) {
  const std::optional<Asset> nothing;
  const auto hash = ContentHash::fromBytes(chunk.hash());
  if (!hash) return refused("asset_chunk.hash", "a SHA-256 hash has 32 bytes");
  const auto at = transfers_.find(*hash);
  if (at == transfers_.end() || at->second.phase != Phase::kRequested) return nothing;
  Transfer& transfer = at->second;
  if (chunk.offset() != transfer.bytes.size()) return nothing;  // of a request that was given up and made again
  if (chunk.kind() != static_cast<v1::AssetKind>(transfer.kind)) {
    return chunkRefused(*hash, "kind",
                        "is " + std::to_string(chunk.kind()) + ", and the scene names it as " +
                            std::to_string(static_cast<int>(transfer.kind)));
  }
  if (chunk.total_size() == 0 || chunk.total_size() > kMaxAssetBytes) {
    return chunkRefused(*hash, "total_size", "is not the size of an asset");
  }
  if (transfer.total_bytes != 0 && chunk.total_size() != transfer.total_bytes) {
    return chunkRefused(*hash, "total_size", "changed under way");
  }
  if (chunk.data().empty() || chunk.data().size() > chunk.total_size() - transfer.bytes.size()) {
    return chunkRefused(*hash, "data", "is empty or goes beyond total_size");
  }
  transfer.total_bytes = chunk.total_size();
  transfer.bytes += chunk.data();
  if (transfer.bytes.size() < transfer.total_bytes) return nothing;
  Asset asset{{transfer.kind, *hash}, std::move(transfer.bytes)};
  transfers_.erase(at);
  return asset;
}

void AssetFetcher::unavailable(const std::string& hash) {
  const auto known = ContentHash::fromBytes(hash);
  if (!known) return;
  if (const auto at = transfers_.find(*known); at != transfers_.end()) at->second.phase = Phase::kUnavailable;
}

void AssetFetcher::retry() {
  for (auto& [hash, transfer] : transfers_) {
    if (transfer.phase == Phase::kUnavailable) transfer.phase = Phase::kWaiting;
  }
}

std::uint64_t AssetFetcher::arriving_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& [hash, transfer] : transfers_) bytes += transfer.total_bytes;
  return bytes;
}

void AssetFetcher::connectionLost() {
  for (auto& [hash, transfer] : transfers_) transfer.phase = Phase::kWaiting;
}

}  // namespace haptics
