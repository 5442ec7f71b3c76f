#pragma once

#include "common/json/json.h"
#include "common/telemetry/motion_state.h"

namespace haptics {

/// A body as both sides' summaries have it, equal when the body is.
[[nodiscard]] inline Json bodyJson(const BodyState& body) {
  constexpr const char* kConditions[] = {"awake", "asleep", "out of bounds", "not finite"};
  const Vec3 p = body.pose.position;
  const Quat q = body.pose.rotation;
  return {{"object", body.object},
          {"position_m", Json::array({p.x, p.y, p.z})},
          {"rotation_wxyz", Json::array({q.w, q.x, q.y, q.z})},
          {"condition", kConditions[static_cast<int>(body.condition)]}};
}

}  // namespace haptics
