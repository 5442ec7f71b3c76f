#pragma once

#include <cstdint>
#include <map>

#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptic_server/scene/scene_service.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics {

/// Which shapes that are driven each of one client's samples tells of: those that are not as the client heard of them last,
/// and all of them now and then, in case that what was sent is lost, or the client comes late.
class ShapeUpdates {
 public:
  static constexpr std::uint64_t kEvery_ns = 500'000'000;

  void add(const ShapePlaces& places, const SceneService::DrivenShapes& shapes, std::uint64_t now_ns,
           v1::Telemetry& sample);

 private:
  struct Sent {
    double at = 0;
    std::uint64_t when_ns = 0;
  };
  std::map<std::uint64_t, Sent> sent_;
};

}  // namespace haptics
