#pragma once

#include <cstdint>
#include <vector>

#include "tests/eval/teleoperation/couplings.h"

namespace haptics::eval {

/// What a hand does over a line: it reaches through free space for 1.5 s and stops where it would be 10 mm below the remote surface;
/// 2.5 s later it presses 5 mm deeper within 1 s, and stops; after another 2.5 s it comes back, and stops.
struct TeleoperationCell {
  const CouplingMethod* method = nullptr;
  DevicePreset master, follower;  ///< The follower is in nobody's hand.
  HandPreset hand;
  LineQuality line;           ///< Each way.
  double remote_N_per_m = 0;  ///< 0: nothing is there.
  std::uint64_t seed = 0;
};

struct TeleoperationRun {
  double least_J = 0;  ///< That hand and contact had put in and not got back: by the plants, not by what encoders said.
  double rest_s =
      0;  ///< After the worst of the stops, until both ends stay within allowedCycle_um() of where they end up.
  double freeError_mm = 0;  ///< Root mean square, on the way: of the follower from where the master was a delay ago;
  double freeForce_N = 0;   ///< of what the hand feels.
  double hand_N = 0, contact_N = 0;  ///< At the end of the second stop,
  double depth_mm = 0;               ///< of the master below the surface, and
  double apart_mm = 0;               ///< between the ends.
  double packets = 0;                ///< Share of the ticks, both ways together.
  double unnoticed =
      0;  ///< Likewise from the follower, in ticks whose force differs from the last one sent by less than noticed.

  struct Sample {
    double time_s, meant_mm, master_mm, follower_mm, felt_N,
        contact_N;  ///< Positive: below the surface, and out of it.
  };
  std::vector<Sample> samples;  ///< Each 10 ms.
};

[[nodiscard]] TeleoperationRun runCell(const TeleoperationCell& cell);

}  // namespace haptics::eval
