#pragma once

#include <cstdint>
#include <functional>

#include "common/scene/scene.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Hears what a session takes from its server, in order, once it is checked. Each may be empty; none may be long.
struct SessionFollower {
  std::function<void(const v1::Welcome&)> welcomed;
  std::function<void(const SceneVersion&)> snapshot;  ///< Replaces what was held; of the last Welcome's epoch.
  std::function<void(const v1::Commit&, const SceneVersion& after)> commit;
  std::function<void(const v1::Telemetry&)> telemetry;  ///< Also one that is older than the newest.
};

/// A scene that was taken from a server before, with which a session resumes.
struct HeldScene {
  std::uint64_t epoch = 0;  ///< Not 0.
  SceneVersion scene;
};

}  // namespace haptics
