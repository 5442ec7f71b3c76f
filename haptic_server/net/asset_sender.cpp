#include "haptic_server/net/asset_sender.h"

namespace haptics {

bool AssetSender::add(const std::shared_ptr<const Asset>& asset, std::uint64_t offset) {
  const ContentHash& hash = asset->name.hash;
  if (underWay_ && underWay_->name.hash == hash) underWay_ = nullptr;
  std::erase_if(waiting_, [&](const Transfer& t) { return t.hash == hash; });
  if (waiting_.size() >= kMaxWaiting) return false;
  waiting_.push_back({hash, asset, offset});
  return true;
}

void AssetSender::next(v1::Envelope& envelope) {
  Transfer& transfer = waiting_.front();
  if (!underWay_) underWay_ = transfer.asset.lock();
  if (!underWay_) {
    envelope.mutable_asset_unavailable()->set_hash(transfer.hash.asBytes());
    waiting_.pop_front();
    return;
  }
  v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
  const CanonicalBytes bytes = underWay_->bytes();
  chunk.set_hash(transfer.hash.asBytes());
  chunk.set_kind(static_cast<v1::AssetKind>(underWay_->name.kind));
  chunk.set_total_size(bytes.size());
  chunk.set_offset(transfer.offset);
  chunk.set_data(bytes.copy(transfer.offset, chunk_bytes_));
  transfer.offset += chunk.data().size();
  if (transfer.offset < bytes.size()) return;
  underWay_ = nullptr;
  waiting_.pop_front();
}

}  // namespace haptics
