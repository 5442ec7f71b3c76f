#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "common/telemetry/motion_state.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics {

/// Which bodies each of one client's samples tells of: those that are not as the client heard of them last, those that
/// have waited longest first, and when there is room one of the others in turn, in case that what was sent of it is lost.
/// So a sample stays within a datagram, and one that comes late hears of all.
class BodyUpdateScheduler {
 public:
  /// Bodies that a sample tells of at most: with the rest of it, 1,100 bytes. Fewer would let a client see bodies by turns
  /// where no more than this move at once.
  static constexpr std::size_t kMax = 8;

  /// Adds the bodies whose turn it is to a sample that is sent.
  void add(const MotionState& motion, v1::Telemetry& sample);

 private:
  struct LastSent {
    BodyState body;
    /// The last one that it had; 0: none. Each body has turns of its own, so that none waits longer.
    std::uint64_t turn = 0;
  };
  std::map<std::uint64_t, LastSent> lastSent_;
  std::uint64_t turn_ = 0;
};

}  // namespace haptics
