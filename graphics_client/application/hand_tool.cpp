#include "graphics_client/application/hand_tool.h"

#include "graphics_client/application/printable_text.h"

namespace haptics {
namespace {

/// A third of a turn across a picture of 800 pixels.
constexpr double kTurn_rad_per_px = 0.0026;

}  // namespace

void HandTool::press() {
  if (lead_ != Lead::kLed) lead_ = Lead::kNone;
}

bool HandTool::isLed(const MirrorView& view) const { return view.hand.isSelf && view.felt(hand_) != nullptr; }

void HandTool::lead(const MirrorView& view, bool touches, const std::optional<SurfacePoint>& surface, double dt_s) {
  const TelemetrySample* felt = view.felt(hand_);
  const bool isLed = this->isLed(view);
  if (lead_ == Lead::kNone && touches && surface && view.link == LinkState::kLive && !view.isReplay) {
    link_.leadHand(true);
    lead_ = Lead::kAsked;
  }
  if (lead_ == Lead::kAsked && isLed) {
    steering_.begin(felt->hip);
    lead_ = Lead::kLed;
  }
  if (lead_ == Lead::kLed && !isLed) lead_ = Lead::kRefused;  // lost, with the connection or to another
  const bool strokes = steering_.mapping() == HandSteering::Mapping::kSurface;
  scene_.showPointer(lead_ == Lead::kLed && strokes ? surface : std::nullopt);
  if (lead_ != Lead::kLed) return;
  if (const auto pressure = view_->penPressure()) {
    steering_.setPress_N(HandSteering::kMinPress_N +
                         *pressure * (HandSteering::kMaxPress_N - HandSteering::kMinPress_N));
  }
  HandSteering::Pointer pointer{.pressed = touches, .surface = surface};
  pointer.eye = scene_.cameras().worldPosition();
  if (const auto pixel = view_->pointer()) {
    pointer.onPicture = scene_.cameras().onPictureThrough(steering_.hand(), (*pixel)[0], (*pixel)[1]);
  }
  link_.commandHand(steering_.next(pointer, felt->hip, dt_s));
}

void HandTool::letGo() {
  lead_ = Lead::kRefused;
  link_.leadHand(false);
}

void HandTool::turn(double right_px, double up_px) {
  const PictureCamera camera = scene_.cameras().picture();
  const Vec3 about = right_px * camera.up - up_px * camera.right;
  const double way_px = glm::length(about);
  if (way_px > 0) steering_.turnBy(glm::angleAxis(kTurn_rad_per_px * way_px, about / way_px));
}

void HandTool::openGripper(const MirrorView& view, double clicks) {
  const TelemetrySample* felt = view.felt(hand_);
  if (isLed(view) && felt->handle.has(HandleReading::kGripper)) steering_.openGripper(clicks, felt->handle.gripper_rad);
}

QString HandTool::words(const MirrorView& view) const {
  const bool onSurface = steering_.mapping() == HandSteering::Mapping::kSurface;
  const QString press = pressText(view);
  if (!view.hand.refused.empty()) return "hand: " + text(view.hand.refused);
  if (view.link != LinkState::kLive) return {};
  if (lead_ == Lead::kLed) {
    const TelemetrySample* felt = view.felt(hand_);
    const bool presses = felt != nullptr && felt->object != 0;
    return "the hand is yours, " + (!onSurface ? "in space: drag to move it, wheel: away and nearer"
                                    : presses  ? "presses with " + press
                                               : "touches nothing; will press with " + press);
  }
  if (view.hand.led) return "hand: led by " + text(view.hand.clientName);
  return onSurface ? "press on an object to touch it with " + press
                   : QString("drag in the picture to move the hand in space");
}

/// What is asked for, and what the device can give of it.
QString HandTool::pressText(const MirrorView& view) const {
  const double wanted_N = steering_.press_N();
  const double device_N = hand_ == 0 ? view.maxForce_N : view.secondMaxForce_N, most_N = device_N / kForceReserve;
  const auto written = [](double force_N) { return QString::number(force_N, 'f', 1); };
  if (!(most_N > 0) || wanted_N <= most_N) return written(wanted_N) + " N";
  return written(most_N) + " of " + written(wanted_N) + " N: the device's " + written(device_N) + " N less a reserve";
}

}  // namespace haptics
