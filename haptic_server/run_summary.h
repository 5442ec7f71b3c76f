#pragma once

#include <string>

#include "common/error/error.h"
#include "haptic_server/net/server.h"
#include "haptic_server/recording/replay_check.h"
#include "haptic_server/scene/scene_history.h"
#include "haptic_server/servo/realtime.h"
#include "haptic_server/servo/servo_loop.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The servo's part of a Status message, with the first hand's.
void fillServoStatus(const ServoStatistics& servo, const HandStatistics& hand, const RealtimeStatus& realtime,
                     v1::Status& status);
void fillHandStatus(const HandStatistics& hand, v1::HandStatus& status);
void fillReplayCheck(const ReplayCheck::Count& count, v1::ReplayCheck& status);

/// Writes what a run came to, and the deformedHash() at its end, as JSON; the keys are a contract with scripts
/// (deploy/README.md, "Summary of a run").
[[nodiscard]] Result<void> writeSummary(const std::string& file, const v1::Status& status, double maxForceLimit_N,
                                        const MotionState& motion, const ContentHash& deformed);

}  // namespace haptics
