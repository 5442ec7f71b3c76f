#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// The dents of one body, in the order in which they are applied.
struct BodyDents {
  union {  // of which no more is written than is used
    std::array<Dent, kMaxDents> dent;
  };
  std::size_t count = 0;

  BodyDents() noexcept {}  // NOLINT(modernize-use-equals-default)

  [[nodiscard]] std::span<const Dent> all() const noexcept { return std::span(dent).first(count); }
};

/// @param without  Index of one that is left out.
[[nodiscard]] inline BodyDents dentsOf(const HapticState& state, std::size_t body,
                                       std::size_t without = kMaxDents) noexcept {
  BodyDents dents;
  for (std::size_t i = 0; i < state.dents.count; ++i) {
    if (state.dents[i].body == body && i != without) dents.dent[dents.count++] = state.dents[i].dent;
  }
  return dents;
}

/// How deep the contact's dent in a body is, m; 0 without one.
[[nodiscard]] inline double pressedDepth_m(const HapticState& state, std::size_t body) noexcept {
  for (const BodyDent& dent : state.allDents()) {
    if (dent.pressed && dent.body == body) return glm::length(Vec3(dent.dent.displacement));
  }
  return 0;
}

}  // namespace haptics
