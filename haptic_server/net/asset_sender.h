#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>

#include "haptic_server/scene/asset_store.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The assets that a client has asked for and not yet got, cut into chunks in the order asked. Holds them alive.
class AssetSender {
 public:
  explicit AssetSender(std::size_t chunk_bytes) noexcept : chunk_bytes_(chunk_bytes) {}

  static constexpr std::size_t kMaxWaiting = 1024;  ///< Requests; four times the objects that a scene can hold.

  /// From this byte on; a second request for the same asset replaces the first. False: too many are waiting.
  [[nodiscard]] bool add(std::shared_ptr<const Asset> asset, std::uint64_t offset);
  [[nodiscard]] bool empty() const noexcept { return waiting_.empty(); }
  void next(v1::AssetChunk& chunk);  ///< Not when empty.

 private:
  struct Transfer {
    std::shared_ptr<const Asset> asset;
    std::uint64_t offset;
  };
  std::size_t chunk_bytes_;
  std::deque<Transfer> waiting_;
};

}  // namespace haptics
