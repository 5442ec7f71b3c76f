#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "haptic_server/engine/step/haptic_state.h"

// A servo's state as bytes: its fields as far as they are in use, for builds that list the same ones.
namespace haptics {

/// Tells builds apart whose states have other fields.
[[nodiscard]] std::uint64_t stateLayout() noexcept;

[[nodiscard]] std::string stateImage(const StateFields& state);

/// The state that the image is of. Untrusted bytes are welcome.
/// @param scene  The one that it had adopted; outlives the state.
/// Refused: bytes that are no image of a state on this scene.
[[nodiscard]] Result<std::unique_ptr<HapticState>> stateFrom(std::string_view image, const ServoScene& scene,
                                                             const StepConfig& config);

}  // namespace haptics
