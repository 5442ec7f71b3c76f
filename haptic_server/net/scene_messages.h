#pragma once

#include <functional>

#include "common/scene/scene.h"
#include "haptic_server/scene/sequencer.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Gives `send` the messages that carry the whole scene, one by one: a scene has at most kMaxServoObjects objects, some
/// 50 KiB, in messages as small as any bulk data.
void sendSnapshot(const SceneVersion& version, const std::function<void(v1::Envelope&)>& send);

/// What became of an edit. What making its assets kept and dropped goes along.
void toWire(const EditOutcome& outcome, v1::EditReply& reply);

}  // namespace haptics
