#pragma once

#include <QString>
#include <optional>

#include "graphics_client/application/hand_steering.h"
#include "graphics_client/application/view_widget.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// The pointer as the hand of a simulated device: asks for its lead, leads it, and says in words how that stands.
class HandTool {
 public:
  /// @param hand  Which the pointer leads, of a server with two.
  HandTool(ServerLink& link, SceneView& scene, ViewWidget* view, std::size_t hand)
      : link_(link), scene_(scene), view_(view), hand_(hand) {}

  [[nodiscard]] HandSteering& steering() { return steering_; }
  /// Asks for the lead at the next touch.
  void press();
  /// Leads the hand where the pointer is, once the server gives it. Once a frame.
  /// @param touches  The pointer touches, and does nothing else.
  /// @param surface  Of an object, under it.
  void lead(const MirrorView& view, bool touches, const std::optional<SurfacePoint>& surface, double dt_s);
  void letGo();
  /// Of another server, or a recording: nothing is led.
  void startAnew() { lead_ = Lead::kNone; }
  [[nodiscard]] bool isLed(const MirrorView& view) const;
  /// Turns the hand as a ball under the pointer, that went so far.
  void turn(double right_px, double up_px);
  /// Its gripper, while it is led and has one, by clicks of a wheel.
  void openGripper(const MirrorView& view, double clicks);
  /// How it stands, and what to do.
  [[nodiscard]] QString words(const MirrorView& view) const;

 private:
  ServerLink& link_;
  SceneView& scene_;
  ViewWidget* view_;
  std::size_t hand_;
  HandSteering steering_;
  /// kRefused: not asked for again before the button is pressed again.
  enum class Lead { kNone, kAsked, kLed, kRefused } lead_ = Lead::kNone;

  [[nodiscard]] QString pressText(const MirrorView& view) const;
};

}  // namespace haptics
