#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "haptic_server/scene/scene_service.h"

namespace haptics {

/// deformedHash() for clients that ask. It takes milliseconds where much gives, so that it is not computed for each.
class DeformedHashCache {
 public:
  /// Longest time that an answer is given again, nanoseconds.
  static constexpr std::uint64_t kEvery_ns = 100'000'000;

  explicit DeformedHashCache(const SceneService& sceneService) : sceneService_(sceneService) {}

  /// Hash of the newest version with these dents, not older than kEvery_ns.
  [[nodiscard]] std::optional<ContentHash> hashOf(const SceneHistory& scene, std::span<const ObjectDent> dents,
                                                  std::uint64_t now_ns) {
    const std::uint64_t revision = scene.version.revision();
    if (!known_ || known_->revision != revision || now_ns - known_->at_ns >= kEvery_ns) {
      known_ = {revision, now_ns, sceneService_.deformedHash(scene.version, dents)};
    }
    return known_->hash;
  }

 private:
  struct Known {
    std::uint64_t revision, at_ns;
    std::optional<ContentHash> hash;
  };
  const SceneService& sceneService_;
  std::optional<Known> known_;
};

}  // namespace haptics
