#include "graphics_client/viewer/object_labels.h"

#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "graphics_client/viewer/palette.h"

namespace haptics {
namespace {

constexpr double kLabelOpacity = 0.72;
/// Margin of the background around the text, in font sizes.
constexpr double kLabelPadding = 0.35, kLabelRadius = 0.35;
/// More could not be read.
constexpr std::size_t kMaxLabels = 64;

/// The middle of the box's lowest edge in the picture that runs across rather than up.
glm::dvec2 footOf(const std::array<glm::dvec2, 8>& corners) {
  glm::dvec2 foot(0, std::numeric_limits<double>::infinity());
  for (std::size_t a = 0; a < corners.size(); ++a) {
    for (const std::size_t bit : {1U, 2U, 4U}) {
      const std::size_t b = a ^ bit;  // across an edge: corners are numbered by their coordinates' bits
      const glm::dvec2 along = corners[b] - corners[a], middle = (corners[a] + corners[b]) / 2.0;
      if (std::abs(along.x) >= std::abs(along.y) && middle.y < foot.y) foot = middle;
    }
  }
  return foot;
}

}  // namespace

ObjectLabels::Label::Label(vtkRenderer* renderer) : background(renderer, palette::kCard, kLabelOpacity) {
  setUpText(text, renderer, palette::kText);
  text->GetTextProperty()->SetJustificationToCentered();
  text->GetTextProperty()->SetVerticalJustificationToCentered();
}

void ObjectLabels::Label::setName(vtkRenderer* renderer, const std::string& newName, double newFont_px) {
  if (newName == name && newFont_px == font_px) return;
  name = newName;
  font_px = newFont_px;
  text->SetInput(name.c_str());
  text->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  double size[2];
  text->GetSize(renderer, size);
  width_px = std::round(size[0] + 2 * kLabelPadding * font_px);
  height_px = std::round(1.15 * font_px + kLabelPadding * font_px);
}

std::vector<LabelWish> ObjectLabels::wishes(const std::vector<NamedBox>& objects) const {
  const int* size = world_->GetSize();
  vtkMatrix4x4* projection =
      world_->GetActiveCamera()->GetCompositeProjectionTransformMatrix(world_->GetTiledAspectRatio(), -1, 1);
  std::vector<LabelWish> wishes;
  for (std::size_t i = 0; i < std::min(objects.size(), kMaxLabels); ++i) {
    const Label& label = *labels_[i];
    LabelWish& wish = wishes.emplace_back(LabelWish{.width = label.width_px, .height = label.height_px});
    std::array<glm::dvec2, 8> corners;
    bool visible = true;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Vec3& corner = objects[i].corners[c];
      const double point[4] = {corner.x, corner.y, corner.z, 1};
      double clip[4];
      projection->MultiplyPoint(point, clip);
      visible &= clip[3] > 0;
      corners[c] = {(clip[0] / clip[3] + 1) / 2 * size[0], (clip[1] / clip[3] + 1) / 2 * size[1]};
    }
    if (!visible) continue;  // the camera is within: the label stays out of the way, in the window's corner
    const glm::dvec2 foot = footOf(corners);
    const auto [left, right] = std::ranges::minmax(corners, {}, &glm::dvec2::x);
    const auto [low, high] = std::ranges::minmax(corners, {}, &glm::dvec2::y);
    wish.x = foot.x;
    wish.y = foot.y;
    wish.named = {left.x, low.y, right.x - left.x, high.y - low.y};
  }
  return wishes;
}

void ObjectLabels::update(const std::vector<NamedBox>& objects, std::span<const PixelBox> taken, double font_px) {
  const std::size_t count = visible_ && objects.size() > 1 ? std::min(objects.size(), kMaxLabels) : 0;
  while (labels_.size() < count) labels_.push_back(std::make_unique<Label>(overlay_));
  for (std::size_t i = 0; i < count; ++i) labels_[i]->setName(overlay_, objects[i].name, font_px);
  std::vector<std::optional<PixelBox>> places;
  if (count > 0) places = placeLabels(wishes(objects), taken);
  places.resize(labels_.size());
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    Label& label = *labels_[i];
    label.background.setVisible(places[i].has_value());
    label.text->SetVisibility(places[i].has_value());
    if (!places[i]) continue;
    label.background.place(*places[i], kLabelRadius * font_px);
    label.text->SetPosition(places[i]->left + places[i]->width / 2, places[i]->bottom + places[i]->height / 2);
  }
}

}  // namespace haptics
