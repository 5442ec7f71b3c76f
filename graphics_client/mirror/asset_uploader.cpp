#include "graphics_client/mirror/asset_uploader.h"

#include <algorithm>
#include <span>
#include <utility>

#include "common/clock/monotonic.h"

namespace haptics {
namespace {

/// What stands around a chunk's data in its frame.
constexpr std::size_t kChunkOverhead_bytes = 128;

}  // namespace

void AssetUploader::add(AssetKind kind, std::string bytes, UploadCallbacks callbacks) {
  if (bytes.empty()) {
    v1::AssetUploadReply reply;
    reply.set_field("chunk.data");
    reply.set_reason("is empty; an asset has bytes");
    if (callbacks.finished) callbacks.finished(reply);
    return;
  }
  const ContentHash hash = Hasher().add(std::as_bytes(std::span(bytes))).finish();
  uploads_.push_back({{kind, hash}, std::move(bytes), std::move(callbacks)});
}

std::optional<v1::AssetUpload> AssetUploader::next() {
  if (uploads_.empty() || waitingUntil_ns_) return std::nullopt;
  Upload& upload = uploads_.front();
  if (upload.sent_bytes == upload.bytes.size()) return std::nullopt;
  const std::size_t size = std::min(chunk_bytes_ - kChunkOverhead_bytes, upload.bytes.size() - upload.sent_bytes);
  v1::AssetUpload message;
  v1::AssetChunk& chunk = *message.mutable_chunk();
  chunk.set_hash(upload.name.hash.asBytes());
  chunk.set_kind(static_cast<v1::AssetKind>(upload.name.kind));
  chunk.set_total_size(upload.bytes.size());
  chunk.set_offset(upload.sent_bytes);
  chunk.set_data(upload.bytes.data() + upload.sent_bytes, size);
  upload.sent_bytes += size;
  if (upload.callbacks.progress) upload.callbacks.progress(upload.sent_bytes, upload.bytes.size());
  return message;
}

bool AssetUploader::cancel(const ContentHash& hash) {
  named(hash);
  const auto upload = std::ranges::find(uploads_, hash, [](const Upload& u) { return u.name.hash; });
  if (upload == uploads_.end()) return false;
  const bool begun = upload->sent_bytes > 0;
  const auto finished = std::move(upload->callbacks.finished);
  uploads_.erase(upload);
  v1::AssetUploadReply reply;
  reply.set_hash(hash.asBytes());
  reply.set_reason("was cancelled");
  if (finished) finished(reply);
  return begun;
}

void AssetUploader::replied(const v1::AssetUploadReply& reply, std::uint64_t now_ns) {
  if (uploads_.empty() || uploads_.front().name.hash.asBytes() != reply.hash()) return;
  Upload& upload = uploads_.front();
  if (reply.retry_after_ms() != 0) {
    if (upload.firstPutOff_ns == 0) upload.firstPutOff_ns = now_ns;
    if (now_ns - upload.firstPutOff_ns < kPatience_ns) {
      upload.sent_bytes = 0;
      waitingUntil_ns_ = now_ns + std::min(reply.retry_after_ms() * kNanosecondsPerMillisecond, kPatience_ns);
      return;
    }
  }
  const auto finished = std::move(upload.callbacks.finished);
  if (reply.accepted()) unnamed_.push_back({upload.name, std::move(upload.bytes)});
  uploads_.pop_front();
  std::size_t unnamed_bytes = 0;
  for (const Upload& each : unnamed_) unnamed_bytes += each.bytes.size();
  for (; unnamed_bytes > kMaxUnnamed_bytes; unnamed_.pop_front()) unnamed_bytes -= unnamed_.front().bytes.size();
  if (finished) finished(reply);
}

void AssetUploader::poll(std::uint64_t now_ns) {
  if (waitingUntil_ns_ && now_ns >= *waitingUntil_ns_) waitingUntil_ns_.reset();
}

void AssetUploader::connectionLost() {
  waitingUntil_ns_.reset();
  if (!uploads_.empty()) uploads_.front().sent_bytes = 0;
  for (; !unnamed_.empty(); unnamed_.pop_back()) {
    uploads_.push_front(std::move(unnamed_.back()));
    uploads_.front().again = true;
  }
}

void AssetUploader::named(const ContentHash& asset) {
  std::erase_if(unnamed_, [&](const Upload& upload) { return upload.name.hash == asset; });
}

}  // namespace haptics
