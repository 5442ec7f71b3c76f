#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>

#include "haptic_server/scene/asset_store.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The assets that a client has asked for and not yet got, cut into chunks in the order asked. Holds the one under way alive:
/// a client that does not read keeps no more of what the scene has let go.
class AssetSender {
 public:
  explicit AssetSender(std::size_t chunk_bytes) noexcept : chunk_bytes_(chunk_bytes) {}

  static constexpr std::size_t kMaxWaiting = 1024;  ///< Requests; four times the objects that a scene can hold.

  /// From this byte on; a second request for the same asset replaces the first. False: too many are waiting.
  [[nodiscard]] bool add(const std::shared_ptr<const Asset>& asset, std::uint64_t offset);
  [[nodiscard]] bool empty() const noexcept { return waiting_.empty(); }
  /// A chunk, or that the asset is gone. Not when empty.
  void next(v1::Envelope& envelope);

 private:
  struct Transfer {
    ContentHash hash;
    std::weak_ptr<const Asset> asset;
    std::uint64_t offset;
  };
  std::size_t chunk_bytes_;
  std::deque<Transfer> waiting_;
  std::shared_ptr<const Asset> underWay_;  // the first, once a chunk of it was sent
};

}  // namespace haptics
