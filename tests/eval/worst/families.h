#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "haptic_server/engine/step/servo_scene.h"

namespace haptics::eval {

/// Scenes of one kind, some 0.1 m large, about the origin. Genes are numbers in [0, 1): the same ones make the same scene.
struct Family {
  static constexpr std::size_t kGenes = 4;

  std::string_view name;
  std::string_view about;
  std::shared_ptr<const ServoScene> (*make)(std::span<const double, kGenes> genes);
  bool bareShapes = true;  ///< Nothing but shapes at rest: what every method renders.
};

/// For the slowest tick: scenes in which some query has much to do.
[[nodiscard]] std::span<const Family> families();

/// Throws std::invalid_argument, listing the names, when there is none called so.
[[nodiscard]] const Family& findFamily(std::string_view name);

}  // namespace haptics::eval
