#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "haptic_server/step/haptic_state.h"

// A servo's state as bytes: those of its memory as far as it is in use, with the pointers left out, which the scene that
// it had adopted gives back. It is for builds whose states look alike, and is bit for bit the state.
namespace haptics {

/// Tells builds apart whose states do not look alike.
[[nodiscard]] std::uint64_t stateLayout() noexcept;

[[nodiscard]] std::string stateImage(const HapticState& state);

/// The state that the image is of. Untrusted bytes are welcome.
/// @param scene  The one that it had adopted; outlives the state.
/// Refused: bytes that are no image of a state on this scene.
[[nodiscard]] Result<std::unique_ptr<HapticState>> stateFrom(std::string_view image, const ServoScene& scene,
                                                             const StepConfig& config);

}  // namespace haptics
