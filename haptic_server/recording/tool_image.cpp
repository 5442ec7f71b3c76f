#include "haptic_server/recording/tool_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <tuple>

#include "haptic_server/recording/image_bytes.h"

namespace haptics {
namespace {

[[nodiscard]] bool isAmount(double value) { return std::isfinite(value) && value >= 0; }

}  // namespace

template <class Contact>
auto ToolContactImage::partsOf(Contact& contact) noexcept {
  return std::tie(contact.cursor_, contact.waited_, contact.isOnWay_, contact.wayTested_, contact.way_, contact.proxy_,
                  contact.moved_, contact.travelled_, contact.bodiesPart_, contact.testCost_, contact.search_,
                  contact.skin_);
}

void ToolContactImage::append(const ToolInHand& tool, std::string& image) {
  const ToolContact& contact = tool.contact;
  put(image, tool.body);
  put(image, contact.touchCount_);
  std::apply([&](const auto&... part) { (put(image, part), ...); }, partsOf(contact));
  for (std::size_t b = 0; b < contact.bodyCount_; ++b) {
    put(image, contact.bodyAt_[b]);
    put(image, contact.bodyTravelled_[b]);
  }
  for (const ToolContact::Touch& touch : contact.touches()) put(image, touch);
  for (std::size_t i = 0; i < contact.pointCount_; ++i) put(image, contact.clearTo_[i]);
  for (std::size_t i = 0; i < contact.sharpCount_; ++i) put(image, contact.sharpClearTo_[i]);
}

bool ToolContactImage::takeFrom(std::string_view& image, const ServoScene& scene, ToolInHand& tool) {
  ToolContact& contact = tool.contact;
  if (!take(image, tool.body) || tool.body >= scene.objects.size() || !scene.objects[tool.body].tool) return false;
  contact.hold(*scene.objects[tool.body].tool);
  std::vector<ToolContact::Obstacle> obstacles;
  for (const ServoObject& object : scene.objects)
    obstacles.push_back({object.pose, object.sharp ? std::span<const Vec3>(*object.sharp) : std::span<const Vec3>()});
  contact.adopt(obstacles);
  bool whole = take(image, contact.touchCount_) && contact.touchCount_ <= contact.touches_.size();
  const auto takeAll = [&](auto&... part) { return (take(image, part) && ...); };
  whole = whole && std::apply(takeAll, partsOf(contact));
  for (std::size_t b = 0; whole && b < contact.bodyCount_; ++b)
    whole = take(image, contact.bodyAt_[b]) && take(image, contact.bodyTravelled_[b]) &&
            isAmount(contact.bodyTravelled_[b]);
  for (std::size_t i = 0; whole && i < contact.touchCount_; ++i) whole = take(image, contact.touches_[i]);
  for (std::size_t i = 0; whole && i < contact.pointCount_; ++i) whole = take(image, contact.clearTo_[i]);
  for (std::size_t i = 0; whole && i < contact.sharpCount_; ++i) whole = take(image, contact.sharpClearTo_[i]);
  return whole && isWhole(contact, scene);
}

bool ToolContactImage::isWhole(const ToolContact& contact, const ServoScene& scene) {
  const std::size_t all = contact.pointCount_ + contact.sharpCount_;
  if (!isFlag(contact.waited_) || contact.cursor_ >= all || !isPose(contact.proxy_)) return false;
  if (!isFlag(contact.isOnWay_) || contact.wayTested_ > all || !isPose(contact.way_)) return false;
  if (!isAmount(contact.moved_) || !isAmount(contact.travelled_) || !isAmount(contact.skin_)) return false;
  if (!(contact.bodiesPart_ > 0 && contact.bodiesPart_ <= 1) || !(isAmount(contact.testCost_) && contact.testCost_ > 0))
    return false;
  const auto isNumber = [](double value) { return std::isfinite(value); };
  const auto isTouch = [&](const ToolContact::Touch& touch) {
    if (!isFlag(touch.ofBody) || touch.body >= contact.bodyCount_ || (touch.side != 1 && touch.side != -1))
      return false;
    const CollisionMesh& surface = touch.ofBody ? *contact.tool_->surface : *scene.objects[touch.body].surface;
    const std::size_t points = touch.ofBody ? contact.sharp_[touch.body].points.size() : contact.pointCount_;
    return touch.triangle < surface.triangleCount() && touch.point < points && isWithinWorld(touch.place) &&
           isWithinWorld(touch.normal) && std::isfinite(touch.offset);
  };
  return std::all_of(contact.bodyAt_.begin(), contact.bodyAt_.begin() + static_cast<std::ptrdiff_t>(contact.bodyCount_),
                     isPose) &&
         std::ranges::all_of(contact.touches(), isTouch) &&
         std::all_of(contact.clearTo_.begin(),
                     contact.clearTo_.begin() + static_cast<std::ptrdiff_t>(contact.pointCount_), isNumber) &&
         std::all_of(contact.sharpClearTo_.begin(),
                     contact.sharpClearTo_.begin() + static_cast<std::ptrdiff_t>(contact.sharpCount_), isNumber);
}

}  // namespace haptics
