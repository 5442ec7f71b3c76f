#pragma once

#include <cstdint>

#include "tests/sim/event_log.h"
#include "tests/sim/mutant.h"
#include "tests/sim/oracle.h"
#include "tests/sim/random.h"
#include "tests/sim/virtual_time.h"

namespace haptics::sim {

/// What all players of one world share.
struct Stage {
  Stage(std::uint64_t seed, Mutant mutant_, EventLog::Mode mode)
      : random(seed), log(mode, time), oracle(log), mutant(mutant_) {}

  VirtualTime time;
  Random random;
  EventLog log;
  Oracle oracle;
  Mutant mutant;
  std::uint64_t sessions = 0;  // so far; the last digits of a session's id
};

}  // namespace haptics::sim
