#pragma once

#include <cstddef>
#include <map>

#include "common/hash/content_hash.h"

namespace haptics {

/// Memory for uploads: of all clients, and of those with one token. One thread.
class UploadBudget {
 public:
  UploadBudget(std::size_t most_bytes, std::size_t mostOfToken_bytes) noexcept
      : maxBytes_(most_bytes), maxOfToken_bytes_(mostOfToken_bytes) {}

  /// False: there is not so much left.
  [[nodiscard]] bool reserve(const ContentHash& token, std::size_t bytes) {
    std::size_t& ofToken_bytes = ofToken_bytes_[token];
    if (bytes > maxBytes_ - used_bytes_ || bytes > maxOfToken_bytes_ - ofToken_bytes) return false;
    used_bytes_ += bytes;
    ofToken_bytes += bytes;
    return true;
  }
  /// Gives back bytes that were reserved with that token.
  void release(const ContentHash& token, std::size_t bytes) {
    used_bytes_ -= bytes;
    const auto at = ofToken_bytes_.find(token);
    if (at != ofToken_bytes_.end() && (at->second -= bytes) == 0) ofToken_bytes_.erase(at);
  }

 private:
  const std::size_t maxBytes_, maxOfToken_bytes_;
  std::size_t used_bytes_ = 0;
  std::map<ContentHash, std::size_t> ofToken_bytes_;
};

}  // namespace haptics
