#include "graphics_client/mirror/mesh_uploader.h"

#include <algorithm>
#include <span>
#include <utility>

#include "common/wire/framing.h"

namespace haptics {
namespace {

/// What stands around a chunk's data in its frame.
constexpr std::size_t kChunkOverhead_bytes = 128;
constexpr std::size_t kDataBytes = kMaxChunkBytes - kChunkOverhead_bytes;

}  // namespace

void MeshUploader::add(std::string bytes, UploadCallbacks callbacks) {
  if (bytes.empty()) {
    v1::AssetUploadReply reply;
    reply.set_field("chunk.data");
    reply.set_reason("is empty; a mesh has bytes");
    if (callbacks.finished) callbacks.finished(reply);
    return;
  }
  const ContentHash hash = Hasher().add(std::as_bytes(std::span(bytes))).finish();
  uploads_.push_back({hash, std::move(bytes), std::move(callbacks)});
}

std::optional<v1::AssetUpload> MeshUploader::next() {
  if (uploads_.empty()) return std::nullopt;
  Upload& upload = uploads_.front();
  if (upload.sent_bytes == upload.bytes.size()) return std::nullopt;
  const std::size_t size = std::min(kDataBytes, upload.bytes.size() - upload.sent_bytes);
  v1::AssetUpload message;
  v1::AssetChunk& chunk = *message.mutable_chunk();
  chunk.set_hash(upload.hash.asBytes());
  chunk.set_kind(v1::ASSET_KIND_MESH);
  chunk.set_total_size(upload.bytes.size());
  chunk.set_offset(upload.sent_bytes);
  chunk.set_data(upload.bytes.data() + upload.sent_bytes, size);
  upload.sent_bytes += size;
  if (upload.callbacks.progress) upload.callbacks.progress(upload.sent_bytes, upload.bytes.size());
  return message;
}

bool MeshUploader::cancel(const ContentHash& hash) {
  const auto upload = std::ranges::find(uploads_, hash, &Upload::hash);
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

void MeshUploader::replied(const v1::AssetUploadReply& reply) {
  if (uploads_.empty() || uploads_.front().hash.asBytes() != reply.hash()) return;
  const auto finished = std::move(uploads_.front().callbacks.finished);
  uploads_.pop_front();
  if (finished) finished(reply);
}

void MeshUploader::connectionLost() {
  if (!uploads_.empty()) uploads_.front().sent_bytes = 0;
}

}  // namespace haptics
