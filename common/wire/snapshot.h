#pragma once

#include <cstddef>
#include <functional>

#include "common/scene/scene.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Tag and length of an object inside a message, at most.
inline constexpr std::size_t kPerObject_bytes = 6;

/// Gives `send` the messages that carry the whole scene, one by one, each of at most chunk_bytes or one object.
void sendSnapshot(const SceneVersion& version, std::size_t chunk_bytes, const std::function<void(v1::Envelope&)>& send);

}  // namespace haptics
