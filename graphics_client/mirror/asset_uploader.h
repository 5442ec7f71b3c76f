#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "common/scene/asset_source.h"
#include "common/wire/framing.h"
#include "graphics_client/mirror/client_callbacks.h"

namespace haptics {

/// Sends assets to the server in chunks, one after the other; one that a lost connection interrupted starts anew. The server keeps
/// one for its connection until an edit names it: after a reconnect those that none has named are sent again.
class AssetUploader {
 public:
  /// Put off by the server for this long, an upload is given up and its refusal reported.
  static constexpr std::uint64_t kPatience_ns = 60'000'000'000;
  /// Of assets that no edit has named; beyond, the oldest are not sent again.
  static constexpr std::size_t kMaxUnnamed_bytes = std::size_t{256} << 20;

  explicit AssetUploader(std::size_t chunk_bytes = kMaxChunkBytes) noexcept : chunk_bytes_(chunk_bytes) {}

  /// Canonical bytes (encodeMesh, encodeField, encodeVertexValues). Their hash names the asset from now on. No bytes:
  /// answered from within.
  void add(AssetKind kind, std::string bytes, UploadCallbacks callbacks);
  /// The next chunk to send; counts as sent. Nothing while the server's reply to a complete asset is awaited.
  [[nodiscard]] std::optional<v1::AssetUpload> next();
  /// The upload of the asset with this hash is not to go on; it finishes as refused, from within.
  /// @return Whether the server has had a part of it and is to be told.
  bool cancel(const ContentHash& hash);
  void replied(const v1::AssetUploadReply& reply, std::uint64_t now_ns);
  /// Call every few milliseconds: an asset for which the server had no room is sent again after a while.
  void poll(std::uint64_t now_ns);
  void connectionLost();
  void named(const ContentHash& asset);  ///< The scene holds this asset from now on.
  /// Edits have to wait: what they name may be among what the server is to get once more.
  [[nodiscard]] bool sendsAgain() const { return !uploads_.empty() && uploads_.front().again; }

 private:
  struct Upload {
    AssetName name;
    std::string bytes;
    UploadCallbacks callbacks;
    std::uint64_t sent_bytes = 0;
    std::uint64_t firstPutOff_ns = 0;  // 0: never
    bool again = false;
  };
  std::size_t chunk_bytes_;     // with what stands around the data
  std::deque<Upload> uploads_;  // those to be sent again come first
  std::deque<Upload> unnamed_;  // the server has them
  std::optional<std::uint64_t> waitingUntil_ns_;
};

}  // namespace haptics
