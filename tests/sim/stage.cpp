#include "tests/sim/stage.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/net/scene_messages.h"

namespace haptics::sim {

Limits Limits::draw(Random& random) {
  Limits limits;
  const auto powerOf2 = [&random](double least, double most) {
    return static_cast<std::size_t>(std::exp2(random.uniform(least, most)));
  };
  if (random.chance(0.6)) limits.startObjects = powerOf2(3, 7);
  if (random.chance(0.7)) limits.maxTriangles = 0;
  if (random.chance(0.4)) return limits;
  constexpr std::size_t kPerObject_bytes = 1U << 10;  // without its details
  constexpr std::size_t kMaxObjects = 256;
  SessionLimits& session = limits.session;
  SceneLimits& scene = limits.scene;
  session.frames.frame_bytes = random.chance(0.6) ? powerOf2(12, 14) : powerOf2(12, 20);
  session.frames.chunk_bytes = std::min(powerOf2(9, 15), session.frames.frame_bytes / 2);
  session.editsPerSecond = random.uniform(20, 200);
  session.editBurst = random.uniform(20, 1000);
  session.sendAhead_bytes = powerOf2(12, 18);
  scene.answer_bytes = session.frames.frame_bytes - kAroundObjects_bytes;
  scene.details_bytes = powerOf2(12, 18);
  scene.assets_bytes = powerOf2(14, 29);
  scene.remembered_edits = powerOf2(2, 10);
  session.backlog_bytes =
      2 * (scene.details_bytes + kMaxObjects * kPerObject_bytes) + session.sendAhead_bytes + session.frames.frame_bytes;
  limits.uploadBudget_bytes = powerOf2(17, 29);
  return limits;
}

}  // namespace haptics::sim
