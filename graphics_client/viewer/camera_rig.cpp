#include "graphics_client/viewer/camera_rig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace haptics {
namespace {

/// Nearer than this the near plane would cut the markers (metres).
constexpr double kSmallestDistance_m = 0.05;
/// Height of the piece of world that the close-up shows at its centre (metres): a press of 2 N at 800 N/m, 2.5 mm deep,
/// takes a seventh of it.
constexpr double kCloseUpHeight_m = 0.018;
/// Time constants of the close-up's and the following camera's motion (seconds): long against the noise of normals
/// from polygon to polygon, short against a stroke.
constexpr double kCentreTime_s = 0.08, kNormalTime_s = 0.5, kFollowTime_s = 0.3;
/// The middle of the close-up is this far behind what it follows, at most.
constexpr double kLatest_m = kCloseUpHeight_m / 4;
/// The close-up looks down on the surface at this angle (radians).
constexpr double kCloseUpElevation_rad = 0.6;

constexpr double kOrbit_deg_per_px = 0.35;
/// Looking straight down the z axis there is no right and left.
constexpr double kSteepest_deg = 85;

/// The clipping range is wider than what it holds by this share at both ends, and twice that before it is made anew.
constexpr double kLoose = 0.8;

/// The share of the way that a first-order low-pass goes in dt.
double gain(double dt_s, double time_s) { return 1 - std::exp(-dt_s / time_s); }

Vec3 toVec(const double v[3]) { return {v[0], v[1], v[2]}; }

}  // namespace

void CameraRig::frame(std::span<const Vec3> points, std::span<const PictureArea> areas, Vec3 direction) {
  if (points.empty() || areas.empty()) return;
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  const double aspect = static_cast<double>(renderWindow_.width_px()) / std::max(renderWindow_.height_px(), 1);
  std::vector<CameraPlace> places;
  for (const PictureArea& area : areas) {
    places.push_back(
        fitCamera(points, direction, glm::radians(camera->GetViewAngle()), aspect, area, kSmallestDistance_m));
  }
  const CameraPlace place = std::ranges::min(
      places, {}, [](const CameraPlace& candidate) { return glm::distance(candidate.position, candidate.focus); });
  camera->SetPosition(place.position.x, place.position.y, place.position.z);
  camera->SetFocalPoint(place.focus.x, place.focus.y, place.focus.z);
  camera->SetViewUp(place.up.x, place.up.y, place.up.z);
}

CameraRig::Look CameraRig::look() {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  return {toVec(camera->GetPosition()), toVec(camera->GetFocalPoint())};
}

void CameraRig::lookAs(const Look& look) {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  camera->SetPosition(look.eye.x, look.eye.y, look.eye.z);
  camera->SetFocalPoint(look.focus.x, look.focus.y, look.focus.z);
  camera->SetViewUp(0, 0, 1);
}

void CameraRig::orbit(double right_px, double up_px) {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  camera->SetViewUp(0, 0, 1);
  camera->Azimuth(-kOrbit_deg_per_px * right_px);
  const double elevation_deg = glm::degrees(std::asin(std::clamp(-direction().z, -1.0, 1.0)));
  camera->Elevation(std::clamp(elevation_deg - kOrbit_deg_per_px * up_px, -kSteepest_deg, kSteepest_deg) -
                    elevation_deg);
}

void CameraRig::pan(double right_px, double up_px) {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  const Vec3 focus = toVec(camera->GetFocalPoint());
  const double centre_x = renderWindow_.width_px() / 2.0, centre_y = renderWindow_.height_px() / 2.0;
  const Vec3 step = focus - onPictureThrough(focus, centre_x + right_px, centre_y + up_px);
  const Vec3 position = toVec(camera->GetPosition()) + step, to = focus + step;
  camera->SetPosition(position.x, position.y, position.z);
  camera->SetFocalPoint(to.x, to.y, to.z);
}

void CameraRig::zoom(double factor) { renderWindow_.world().solid->GetActiveCamera()->Dolly(factor); }

Vec3 CameraRig::direction() {
  return toVec(renderWindow_.world().solid->GetActiveCamera()->GetDirectionOfProjection());
}

PictureCamera CameraRig::picture() {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  PictureCamera picture;
  picture.eye = toVec(camera->GetPosition());
  picture.into = direction();
  picture.right = glm::normalize(glm::cross(picture.into, toVec(camera->GetViewUp())));
  picture.up = glm::cross(picture.right, picture.into);
  picture.pixelWidth = 2 * std::tan(glm::radians(camera->GetViewAngle()) / 2) / renderWindow_.height_px();
  picture.size_px = PicturePoint(renderWindow_.width_px(), renderWindow_.height_px());
  return picture;
}

Vec3 CameraRig::onPictureThrough(Vec3 place, double x_px, double y_px) {
  const PictureCamera camera = picture();
  return camera.eye + camera.ray({x_px, y_px}) * std::max(camera.depth_m(place), kSmallestDistance_m);
}

void CameraRig::update(const TelemetrySample* sample, double dt_s) {
  if (sample) {
    if (follow_) follow(sample->ihip, dt_s);
    aimCloseUp(*sample, dt_s);
  }
  double bounds[6];
  renderWindow_.world().solid->ComputeVisiblePropBounds(bounds);
  if (bounds[0] <= bounds[1]) clip(bounds);
}

/// A range that holds what is seen stays, so that depths of before can be compared with.
void CameraRig::clip(const double bounds[6]) {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  const std::array<double, 2> before{camera->GetClippingRange()[0], camera->GetClippingRange()[1]};
  renderWindow_.world().solid->ResetCameraClippingRange(bounds);
  const auto [near_m, far_m] = std::array<double, 2>{camera->GetClippingRange()[0], camera->GetClippingRange()[1]};
  const bool holds = before[0] <= near_m && before[1] >= far_m;
  const bool isTight = before[0] >= near_m * kLoose * kLoose && before[1] <= far_m / kLoose / kLoose;
  if (holds && isTight) {
    camera->SetClippingRange(before[0], before[1]);
  } else {
    camera->SetClippingRange(near_m * kLoose, far_m / kLoose);
  }
}

void CameraRig::follow(Vec3 place, double dt_s) {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  const Vec3 step = (place - toVec(camera->GetFocalPoint())) * gain(dt_s, kFollowTime_s);
  const Vec3 position = toVec(camera->GetPosition()) + step, focus = toVec(camera->GetFocalPoint()) + step;
  camera->SetPosition(position.x, position.y, position.z);
  camera->SetFocalPoint(focus.x, focus.y, focus.z);
}

void CameraRig::aimCloseUp(const TelemetrySample& sample, double dt_s) {
  const bool touching = sample.object != 0;
  const Vec3 centre = touching ? sample.ihip : sample.hip;
  centre_ = seen_ ? glm::mix(centre_, centre, gain(dt_s, kCentreTime_s)) : centre;
  if (const double late_m = glm::distance(centre_, centre); late_m > kLatest_m)
    centre_ = glm::mix(centre, centre_, kLatest_m / late_m);
  if (touching) {
    const Vec3 turned = glm::mix(normal_, sample.surfaceNormal, gain(dt_s, kNormalTime_s));
    if (glm::length(turned) > 0) normal_ = glm::normalize(turned);
  }
  seen_ = true;
  // From where the world's camera stands, but low over the surface: HIP, IHIP and force are then side by side.
  Vec3 along = toVec(renderWindow_.world().solid->GetActiveCamera()->GetDirectionOfProjection());
  along -= normal_ * glm::dot(along, normal_);
  if (!(glm::length(along) > 0)) return;
  const Vec3 direction =
      glm::normalize(along) * std::cos(kCloseUpElevation_rad) - normal_ * std::sin(kCloseUpElevation_rad);
  vtkCamera* camera = renderWindow_.closeUp().solid->GetActiveCamera();
  const double distance = kCloseUpHeight_m / 2 / std::tan(glm::radians(camera->GetViewAngle()) / 2);
  const Vec3 position = centre_ - direction * distance;
  camera->SetPosition(position.x, position.y, position.z);
  camera->SetFocalPoint(centre_.x, centre_.y, centre_.z);
  camera->SetViewUp(normal_.x, normal_.y, normal_.z);
  camera->SetClippingRange(distance * 0.5, distance * 8);
}

double CameraRig::worldMetresPerPixel(Vec3 place) {
  vtkCamera* camera = renderWindow_.world().solid->GetActiveCamera();
  const double depth = glm::dot(place - toVec(camera->GetPosition()), toVec(camera->GetDirectionOfProjection()));
  return 2 * std::max(depth, kSmallestDistance_m) * std::tan(glm::radians(camera->GetViewAngle()) / 2) /
         renderWindow_.height_px();
}

double CameraRig::closeUpMetresPerPixel() { return kCloseUpHeight_m / std::max(renderWindow_.closeUpSide_px(), 1); }

Vec3 CameraRig::worldPosition() { return toVec(renderWindow_.world().solid->GetActiveCamera()->GetPosition()); }

Vec3 CameraRig::closeUpPosition() { return toVec(renderWindow_.closeUp().solid->GetActiveCamera()->GetPosition()); }

}  // namespace haptics
