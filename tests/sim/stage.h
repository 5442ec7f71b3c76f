#pragma once

#include <cstddef>
#include <cstdint>

#include "haptic_server/net/server_session.h"
#include "haptic_server/scene/preparation.h"
#include "haptic_server/scene/scene_limits.h"
#include "tests/sim/event_log.h"
#include "tests/sim/mutant.h"
#include "tests/sim/oracle.h"
#include "tests/sim/random.h"
#include "tests/sim/virtual_time.h"

namespace haptics::sim {

/// How much of what one world has room for.
struct Limits {
  SessionLimits session;
  SceneLimits scene;
  std::size_t uploadBudget_bytes = 512U << 20;
  std::size_t startObjects = 0;                           ///< Beside the counters.
  std::size_t maxTriangles = Preparation::kMaxTriangles;  ///< 0: every edit that makes something is prepared.

  /// Those of the protocol, or any that leave room for an object.
  [[nodiscard]] static Limits draw(Random& random);
};

/// What all players of one world share.
struct Stage {
  Stage(std::uint64_t seed, Mutant mutant_, EventLog::Mode mode)
      : random(seed), limits(Limits::draw(random)), log(mode, time), oracle(log, limits.session), mutant(mutant_) {}

  VirtualTime time;
  Random random;
  const Limits limits;
  EventLog log;
  Oracle oracle;
  Mutant mutant;
  std::uint64_t sessions = 0;  // so far; the last digits of a session's id
};

}  // namespace haptics::sim
