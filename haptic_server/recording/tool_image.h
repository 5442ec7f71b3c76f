#pragma once

#include <string>
#include <string_view>

#include "haptic_server/step/haptic_state.h"
#include "haptic_server/step/servo_scene.h"

namespace haptics {

/// What a tool in the hand remembers, as a part of the image of a state (state_image.h).
class ToolContactImage {
 public:
  static void append(const ToolInHand& tool, std::string& image);
  /// @param scene  Of the state, whose bodies stand already.
  /// @return False: it is none that a tool of this scene can have left.
  [[nodiscard]] static bool takeFrom(std::string_view& image, const ServoScene& scene, ToolInHand& tool);

 private:
  template <class Contact>
  [[nodiscard]] static auto partsOf(Contact& contact) noexcept;
  [[nodiscard]] static bool isWhole(const ToolContact& contact, const ServoScene& scene);
};

}  // namespace haptics
