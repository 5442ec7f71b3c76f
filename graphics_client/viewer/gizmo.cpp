#include "graphics_client/viewer/gizmo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptics {
namespace {

/// Cosine between an arrow and the line of sight above which it is not shown: a quarter of its length is then seen.
constexpr double kAlongSight = 0.968;
/// Cosine between a ring's axis and the line of sight below which the ring is seen edge-on: angles on it are then too coarse
/// from pixel to pixel, and it is turned as a wheel is by its rim.
constexpr double kEdgeOn = 0.25;
constexpr int kRingPieces = 64;
/// Squared sine between line and ray below which they run alike.
constexpr double kAlike = 1e-4;
/// An object is dragged at most so far (metres).
constexpr double kFarthest_m = 2;

constexpr std::array kHandles{GizmoHandle{GizmoHandle::Kind::kMove, 0}, GizmoHandle{GizmoHandle::Kind::kMove, 1},
                              GizmoHandle{GizmoHandle::Kind::kMove, 2}, GizmoHandle{GizmoHandle::Kind::kTurn, 0},
                              GizmoHandle{GizmoHandle::Kind::kTurn, 1}, GizmoHandle{GizmoHandle::Kind::kTurn, 2}};

Vec3 unit(int axis) {
  Vec3 direction(0);
  direction[axis] = 1;
  return direction;
}

/// On the unit ring about an axis.
Vec3 onRing(int axis, double angle) {
  return unit((axis + 1) % 3) * std::cos(angle) + unit((axis + 2) % 3) * std::sin(angle);
}

double angleOfPiece(int piece) { return 2 * std::numbers::pi * piece / kRingPieces; }

double distanceToSegment(PicturePoint place, PicturePoint begin, PicturePoint end) {
  const PicturePoint way = end - begin;
  const double squared = glm::dot(way, way);
  const double share = squared > 0 ? std::clamp(glm::dot(place - begin, way) / squared, 0.0, 1.0) : 0;
  return glm::distance(place, begin + way * share);
}

double cosineToSight(const PictureCamera& camera, Vec3 centre, Vec3 axis) {
  const Vec3 sight = centre - camera.eye;
  return std::abs(glm::dot(axis, sight)) / std::max(glm::length(sight), std::numeric_limits<double>::min());
}

}  // namespace

Gizmo::Gizmo(const PictureCamera& camera, Vec3 centre, GizmoHandles handles)
    : camera_(camera),
      centre_(centre),
      handles_(handles),
      metresPerPixel_(std::max(camera.depth_m(centre), 0.0) * camera.pixelWidth) {}

bool Gizmo::isShown(const GizmoHandle& handle) const {
  const bool isThere = handle.kind == GizmoHandle::Kind::kTurn ? handles_.turns : handles_.moves;
  if (!isThere || !(metresPerPixel_ > 0)) return false;
  return handle.kind == GizmoHandle::Kind::kTurn || cosineToSight(camera_, centre_, unit(handle.axis)) < kAlongSight;
}

double Gizmo::distance_px(const GizmoHandle& handle, PicturePoint pointer) const {
  double nearest = std::numeric_limits<double>::infinity();
  const auto piece = [&](Vec3 begin, Vec3 end) {
    const auto from = camera_.project(centre_ + begin * metresPerPixel_);
    const auto to = camera_.project(centre_ + end * metresPerPixel_);
    if (from && to) nearest = std::min(nearest, distanceToSegment(pointer, *from, *to));
  };
  if (handle.kind == GizmoHandle::Kind::kMove) {
    piece(unit(handle.axis) * kArrowStart_px, unit(handle.axis) * kArrow_px);
    return nearest;
  }
  for (int i = 0; i < kRingPieces; ++i) {
    piece(onRing(handle.axis, angleOfPiece(i)) * kRing_px, onRing(handle.axis, angleOfPiece(i + 1)) * kRing_px);
  }
  return nearest;
}

std::optional<GizmoHandle> Gizmo::handleAt(PicturePoint pointer) const {
  std::optional<GizmoHandle> found;
  double nearest = kReach_px;
  for (const GizmoHandle& handle : kHandles) {
    if (!isShown(handle)) continue;
    const double distance = distance_px(handle, pointer);
    if (distance > nearest) continue;
    nearest = distance;
    found = handle;
  }
  return found;
}

GizmoDrag::GizmoDrag(const GizmoHandle& handle, const Gizmo& gizmo, const Pose& pose, const PictureCamera& camera,
                     PicturePoint pointer)
    : handle_(handle), centre_(gizmo.centre()), axis_(unit(handle.axis)), pose_(pose), line_(centre_), along_(axis_) {
  const bool isEdgeOn = cosineToSight(camera, centre_, axis_) < kEdgeOn;
  if (handle.kind == GizmoHandle::Kind::kTurn && isEdgeOn) {
    radius_m_ = Gizmo::kRing_px * gizmo.metresPerPixel();
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kRingPieces; ++i) {
      const Vec3 spoke = onRing(handle.axis, angleOfPiece(i));
      const auto seen = camera.project(centre_ + spoke * *radius_m_);
      if (!seen || glm::dot(spoke, camera.eye - centre_) < 0 || glm::distance(*seen, pointer) >= nearest) continue;
      nearest = glm::distance(*seen, pointer);
      line_ = centre_ + spoke * *radius_m_;
      along_ = glm::cross(axis_, spoke);
    }
  }
  static_cast<void>(moveTo(camera, pointer));
}

std::optional<double> GizmoDrag::angleOf(const PictureCamera& camera, PicturePoint pointer) const {
  const Vec3 ray = camera.ray(pointer);
  const double across = glm::dot(ray, axis_);
  if (across == 0) return std::nullopt;
  const double depth_m = glm::dot(centre_ - camera.eye, axis_) / across;
  if (!(depth_m > 0)) return std::nullopt;
  const Vec3 spoke = camera.eye + ray * depth_m - centre_;
  return std::atan2(glm::dot(spoke, onRing(handle_.axis, std::numbers::pi / 2)),
                    glm::dot(spoke, onRing(handle_.axis, 0)));
}

Pose GizmoDrag::moveTo(const PictureCamera& camera, PicturePoint pointer) {
  const bool turns = handle_.kind == GizmoHandle::Kind::kTurn;
  const bool onPlane = turns && !radius_m_;
  if (const auto place = onPlane ? angleOf(camera, pointer) : nearestOnLine(line_, along_, camera, pointer)) {
    if (!begin_) begin_ = place;
    now_ = onPlane ? *place : std::clamp(*place, *begin_ - kFarthest_m, *begin_ + kFarthest_m);
  }
  if (!turns) return {pose_.rotation, pose_.position + centre() - centre_};
  const double turned = begin_ ? (*now_ - *begin_) / radius_m_.value_or(1) : 0;
  const Quat turn = glm::angleAxis(turned, axis_);
  return {glm::normalize(turn * pose_.rotation), centre_ + turn * (pose_.position - centre_)};
}

Vec3 GizmoDrag::centre() const {
  if (handle_.kind == GizmoHandle::Kind::kTurn || !begin_) return centre_;
  return centre_ + axis_ * (*now_ - *begin_);
}

std::optional<double> nearestOnLine(Vec3 start, Vec3 along, const PictureCamera& camera, PicturePoint pointer) {
  // |start + s along - (eye + t ray)| is least where both directions are across the difference; with w = start - eye:
  //   s + w . along - t (along . ray) = 0,   s (along . ray) + w . ray - t (ray . ray) = 0
  const Vec3 ray = glm::normalize(camera.ray(pointer)), w = start - camera.eye;
  const double cosine = glm::dot(along, ray), squaredSine = 1 - cosine * cosine;
  if (squaredSine < kAlike) return std::nullopt;
  const double t = (glm::dot(w, ray) - glm::dot(w, along) * cosine) / squaredSine;
  if (!(t > 0)) return std::nullopt;
  return (glm::dot(w, ray) * cosine - glm::dot(w, along)) / squaredSine;
}

}  // namespace haptics
