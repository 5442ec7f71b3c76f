#include "haptic_server/net/asset_sender.h"

#include <utility>

namespace haptics {

bool AssetSender::add(std::shared_ptr<const Asset> asset, std::uint64_t offset) {
  std::erase_if(waiting_, [&](const Transfer& t) { return t.asset->name == asset->name; });
  if (waiting_.size() >= kMaxWaiting) return false;
  waiting_.push_back({std::move(asset), offset});
  return true;
}

void AssetSender::next(v1::AssetChunk& chunk) {
  Transfer& transfer = waiting_.front();
  const CanonicalBytes bytes = transfer.asset->bytes();
  chunk.set_hash(transfer.asset->name.hash.asBytes());
  chunk.set_kind(static_cast<v1::AssetKind>(transfer.asset->name.kind));
  chunk.set_total_size(bytes.size());
  chunk.set_offset(transfer.offset);
  chunk.set_data(bytes.copy(transfer.offset, chunk_bytes_));
  transfer.offset += chunk.data().size();
  if (transfer.offset == bytes.size()) waiting_.pop_front();
}

}  // namespace haptics
