#include "haptic_server/net/session_uploads.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/text/printable.h"
#include "common/wire/convert.h"

namespace haptics {
namespace {

v1::AssetUploadReply acceptedReply(const ContentHash& hash) {
  v1::AssetUploadReply reply;
  reply.set_hash(hash.asBytes());
  reply.set_accepted(true);
  return reply;
}

v1::AssetUploadReply refusedReply(const std::string& hash, const Error& error) {
  v1::AssetUploadReply reply;
  reply.set_hash(hash);
  reply.set_field(asUtf8(error.field));
  reply.set_reason(asUtf8(error.reason));
  return reply;
}

Error noRoom() { return {"chunk.total_size", "the server has no room for so large an upload now; try again later"}; }

/// How long a client is to wait when there is no room now: others' uploads take seconds.
constexpr std::uint32_t kRetryAfter_ms = 1000;

}  // namespace

std::optional<v1::AssetUploadReply> SessionUploads::take(const v1::AssetChunk& chunk, std::uint64_t now_ns) {
  const auto hash = hashFromWire(chunk.hash(), "chunk.hash");
  if (!hash) return refusedReply({}, hash.error());
  if (assembly_.ignores(chunk, *hash)) return std::nullopt;
  const auto kind = assetKindFromWire(chunk.kind(), "chunk.kind");
  if (!kind) return refuse(*hash, kind.error());
  const AssetName name{*kind, *hash};
  if (const auto checked = assembly_.check(chunk, name); !checked) return refuse(*hash, checked.error());
  if (chunk.offset() == 0) {
    releaseAssembly();
    if (const auto at = building_.find(*hash); at != building_.end()) {  // answered when it is built
      at->second.wanted = true;
      assembly_.abandon(*hash);
      return std::nullopt;
    }
    if (auto known = scene_.findAsset(*hash); known && known->name == name) {
      if (std::ranges::find(held_, known, &Held::asset) == held_.end()) {
        const std::size_t bytes = known->bytes().size();  // the scene may let it go while the client holds it
        if (!host_.reserveUpload(bytes)) return retryLater(*hash, noRoom());
        hold(std::move(known), bytes);
      }
      assembly_.abandon(*hash);
      return acceptedReply(*hash);
    }
  }
  if (!reserveFor(chunk)) return retryLater(*hash, noRoom());
  lastChunk_ns_ = now_ns;
  assembly_.add(chunk, name);
  if (!assembly_.complete()) return std::nullopt;
  Building& building = building_[*hash];
  if (!host_.submitAsset(name, assembly_.take())) {
    building_.erase(*hash);
    return retryLater(*hash, {"busy", "the server has too many edits waiting; try again later"});
  }
  building.reserved = std::exchange(assemblyReserved_, 0);  // only now: where that threw, clear() gives it back
  return std::nullopt;
}

std::optional<v1::AssetUploadReply> SessionUploads::poll(std::uint64_t now_ns) {
  const auto hash = assembly_.assembled();
  if (!hash || now_ns - lastChunk_ns_ < kStalled_ns) return std::nullopt;
  return refuse(*hash, {"chunk", "none came for 10 s; begin the upload again"});
}

std::optional<v1::AssetUploadReply> SessionUploads::turnAway(const v1::AssetChunk& chunk, const Error& why) {
  const auto hash = hashFromWire(chunk.hash(), "chunk.hash");
  if (!hash) return refusedReply({}, hash.error());
  if (assembly_.ignores(chunk, *hash)) return std::nullopt;
  return refuse(*hash, why);
}

std::optional<v1::AssetUploadReply> SessionUploads::decided(const ContentHash& hash,
                                                            Result<std::shared_ptr<const Asset>> outcome) {
  const auto at = building_.find(hash);
  if (at == building_.end()) return std::nullopt;
  const auto [reserved, wanted] = at->second;
  building_.erase(at);
  if (!wanted || !outcome) host_.releaseUpload(reserved);
  if (!wanted) return std::nullopt;
  if (!outcome) {
    return refusedReply(hash.asBytes(), std::move(outcome).error().within("chunk."));
  }
  hold(*std::move(outcome), reserved);
  return acceptedReply(hash);
}

void SessionUploads::cancel(const ContentHash& hash) {
  if (assembly_.assembles(hash)) {
    releaseAssembly();
    assembly_.abandon(hash);
  }
  if (const auto at = building_.find(hash); at != building_.end()) at->second.wanted = false;
  named(hash);
}

void SessionUploads::named(const ContentHash& asset) {
  std::erase_if(held_, [&](const Held& held) {
    if (held.asset->name.hash != asset) return false;
    host_.releaseUpload(held.reserved);
    return true;
  });
}

void SessionUploads::clear() {
  releaseAssembly();
  for (auto& [hash, building] : building_) building.wanted = false;
  for (const Held& held : held_) host_.releaseUpload(held.reserved);
  held_.clear();
}

v1::AssetUploadReply SessionUploads::refuse(const ContentHash& hash, const Error& error) {
  releaseAssembly();
  assembly_.abandon(hash);
  return refusedReply(hash.asBytes(), error);
}

v1::AssetUploadReply SessionUploads::retryLater(const ContentHash& hash, const Error& why) {
  v1::AssetUploadReply reply = refuse(hash, why);
  reply.set_retry_after_ms(kRetryAfter_ms);
  return reply;
}

void SessionUploads::hold(std::shared_ptr<const Asset> asset, std::size_t reserved) {
  named(asset->name.hash);
  held_.push_back({std::move(asset), reserved});
  if (held_.size() <= kMaxHeld) return;
  host_.releaseUpload(held_.front().reserved);
  held_.pop_front();
}

bool SessionUploads::reserveFor(const v1::AssetChunk& chunk) {
  const std::size_t needed = chunk.offset() + chunk.data().size();
  if (needed <= assemblyReserved_) return true;
  const std::size_t wanted =
      std::min<std::size_t>(chunk.total_size(), std::max(kMinReserve_bytes, 2 * assemblyReserved_));
  if (!host_.reserveUpload(wanted - assemblyReserved_)) return false;
  assemblyReserved_ = wanted;
  return true;
}

void SessionUploads::releaseAssembly() { host_.releaseUpload(std::exchange(assemblyReserved_, 0)); }

}  // namespace haptics
