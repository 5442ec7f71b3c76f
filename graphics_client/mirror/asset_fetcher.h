#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/scene/asset_source.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Brings in the assets that the client lacks, a few at a time, and goes on where it was after a reconnect.
class AssetFetcher {
 public:
  /// Requests that wait for the server at once: enough that the line never idles, few enough that the first is soon
  /// complete.
  static constexpr std::size_t kMaxInFlight = 4;

  struct Asset {
    AssetName name;
    std::string bytes;
  };

  /// What is lacking now. What was under way and is not in the list is given up.
  void want(const std::vector<AssetName>& lacking);
  /// The next request to send; counts as sent.
  [[nodiscard]] std::optional<v1::AssetRequest> next();
  /// The asset that the chunk completes; its bytes are not checked here. Chunks of what was given up are ignored.
  /// Refused: a chunk that does not fit its asset.
  [[nodiscard]] Result<std::optional<Asset>> take(const v1::AssetChunk& chunk);
  /// The server does not hold it (any more). It is asked for again after retry().
  void unavailable(const std::string& hash);
  void retry();
  void connectionLost();
  /// All bytes, there or to come, of what is arriving.
  [[nodiscard]] std::uint64_t arriving_bytes() const;

 private:
  enum class Phase { kWaiting, kRequested, kUnavailable };
  struct Transfer {
    AssetKind kind = AssetKind::kMesh;
    Phase phase = Phase::kWaiting;
    std::string bytes{};
    std::uint64_t total_bytes = 0;  // 0: not known yet
  };
  std::map<ContentHash, Transfer> transfers_;
};

}  // namespace haptics
