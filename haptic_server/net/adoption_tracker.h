#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Tells a client from which tick its accepted edits are felt: with the first adoption of their revision or a later
/// one. Adoption and acceptance may come in either order.
class AdoptionTracker {
 public:
  static constexpr std::size_t kMaxAwaited = 4096;   ///< Beyond, the oldest are left to the next heartbeat.
  static constexpr std::size_t kMaxAdoptions = 256;  ///< Remembered for edits whose acceptance comes late.

  /// The servo feels `revision` since `tick`. Only a revision newer than the last counts.
  void adopted(std::uint64_t revision, std::uint64_t tick);
  void accepted(std::uint64_t clientSeq, std::uint64_t revision);
  /// The edits whose tick became known since the last call, in order of acceptance.
  [[nodiscard]] std::vector<v1::EditLive> take();

  struct Adoption {
    std::uint64_t revision = 0, tick = 0;
  };
  [[nodiscard]] Adoption newest() const { return adoptions_.empty() ? Adoption{} : adoptions_.back(); }

 private:
  struct Awaited {
    std::uint64_t clientSeq, revision;
  };
  std::deque<Adoption> adoptions_;  // ascending
  std::deque<Awaited> awaited_;
};

}  // namespace haptics
