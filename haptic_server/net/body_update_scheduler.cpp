#include "haptic_server/net/body_update_scheduler.h"

#include <algorithm>
#include <vector>

#include "common/wire/convert.h"

namespace haptics {

void BodyUpdateScheduler::add(const MotionState& motion, v1::Telemetry& sample) {
  if (motion.bodyCount == 0 && lastSent_.empty()) return;
  std::erase_if(lastSent_, [&](const auto& entry) {
    return std::ranges::find(motion.bodies(), entry.first, &BodyState::object) == motion.bodies().end();
  });
  struct Waiting {
    const BodyState* body;
    bool isNews;
    std::uint64_t since;
  };
  std::vector<Waiting> waiting;
  for (const BodyState& body : motion.bodies()) {
    const LastSent& last = lastSent_[body.object];
    waiting.push_back({&body, last.turn == 0 || !(last.body == body), last.turn});
  }
  std::ranges::sort(
      waiting, [](const Waiting& a, const Waiting& b) { return a.isNews != b.isNews ? a.isNews : a.since < b.since; });
  std::size_t taken = (motion.dentCount + 1) / 2;  // a dent takes less than half of what a body does,
  if (motion.tool.object != 0) {
    toWire(motion.tool, *sample.mutable_tool());
    taken += motion.tool.pointCount + 1;  // and a point of a tool no more than one
  }
  constexpr std::size_t kSecondHand =
      6;  // in bodies: its sample without what is the servo's takes some 450 bytes by its fields
  if (sample.has_second_hand()) taken += kSecondHand;
  const std::size_t most = taken < kMax ? kMax - taken : 1;
  std::size_t count = 0;
  for (const Waiting& next : waiting) {
    if (count == most) break;
    toWire(*next.body, *sample.add_body());
    lastSent_[next.body->object] = {*next.body, ++turn_};
    ++count;
    if (!next.isNews) break;
  }
}

}  // namespace haptics
