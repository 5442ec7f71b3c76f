#include "haptic_server/engine/collision/polytope_contact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "haptic_server/engine/collision/clipped_polygon.h"
#include "haptic_server/engine/collision/level_axis.h"

namespace haptics {
namespace {

/// Sine below which two directions are parallel.
constexpr double kParallel = 1e-4;
/// An axis of two edges, and one of the first's faces, has to be better by so much, m: faces that lie on each other do not
/// take turns.
constexpr double kBetter_m = 2e-6;
/// Where the axis of two edges is so near to a face's (15 degrees), the edges meet at the border of what the faces share.
constexpr double kAlong = 0.966;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

enum class AxisKind { kFaceOfSecond, kFaceOfFirst, kEdges };

/// Without initialisers: arrays are filled as far as they are used.
struct Axis {
  AxisKind kind;
  std::uint8_t a, b;  ///< Faces, or directions of edges.
  Vec3 normal;        ///< Out of the second.
  double gap_m;
  Vec3 nearest;  ///< Of a face's axis: the corner that is nearest to it.
};

constexpr Axis kNoAxis{AxisKind::kEdges, 0, 0, Vec3(0), -kInfinite, Vec3(0)};

/// Two polytopes of few faces, in the second's frame.
class Meeting {
 public:
  Meeting(const Polytope& first, const Polytope& second, const Pose& relative, const PolytopeWay& way) noexcept
      : first_(first), second_(second), frame_(relative), way_(way) {
    for (std::size_t i = 0; i < first.corners.size(); ++i) corners_[i] = frame_.toWorld(first.corners[i]);
  }

  [[nodiscard]] PolytopeContact find() noexcept {
    findAxis();
    PolytopeContact made;
    made.normal = best_.normal;
    made.gap_m = best_.gap_m;
    if (best_.gap_m > way_.range_m) return made;
    if (best_.kind == AxisKind::kEdges && glm::dot(best_.normal, face_.normal) > kAlong) {
      addFace(face_, made);
      if (made.count > 0) {
        made.normal = face_.normal;
        return made;
      }
    }
    if (best_.kind == AxisKind::kEdges) {
      addEdges(best_, made);
    } else if (const Axis* const axis = levelAxis(made.isOneOfTwo)) {
      made.normal = axis->normal;
      addFace(*axis, made);
      if (axis != &best_) return made;
    } else {
      return made;
    }
    if (made.count == 0 && best_.gap_m > 0) addClosest(made);
    return made;
  }

 private:
  const Polytope &first_, &second_;
  Frame frame_;
  const PolytopeWay& way_;
  std::array<Vec3, Polytope::kFewCorners> corners_;  // of the first
  std::array<Axis, 2 * Polytope::kFewFaces> faces_;
  std::size_t faceCount_ = 0;
  Axis best_ = kNoAxis, face_ = kNoAxis;  // of all axes, and of the faces'

  [[nodiscard]] std::span<const Vec3> firstCorners() const noexcept {
    return std::span(corners_).first(first_.corners.size());
  }

  /// The corner that lies least far along a direction.
  [[nodiscard]] static Vec3 leastOf(std::span<const Vec3> corners, Vec3 along) noexcept {
    Vec3 least = corners[0];
    double at = glm::dot(along, least);
    for (const Vec3 corner : corners.subspan(1)) {
      if (const double here = glm::dot(along, corner); here < at) {
        at = here;
        least = corner;
      }
    }
    return least;
  }

  void take(const Axis& axis, double better_m) noexcept {
    if (axis.gap_m > best_.gap_m + better_m && !way_.isTurnedOver(axis.normal)) best_ = axis;
  }

  void findAxis() noexcept {
    for (std::uint8_t f = 0; f < second_.faces.size(); ++f) {
      const Polytope::Face& face = second_.faces[f];
      const Vec3 corner = leastOf(firstCorners(), face.normal);
      faces_[faceCount_++] = {
          AxisKind::kFaceOfSecond, 0, f, face.normal, glm::dot(face.normal, corner) - face.offset_m, corner};
      take(faces_[faceCount_ - 1], 0);
      if (best_.gap_m > way_.range_m) return;
    }
    double better_m = kBetter_m;
    for (std::uint8_t f = 0; f < first_.faces.size(); ++f) {
      const Polytope::Face& face = first_.faces[f];
      const Vec3 out = frame_.rotate(face.normal);
      const double offset_m = face.offset_m + glm::dot(out, frame_.origin);
      const Vec3 corner = leastOf(second_.corners, out);
      faces_[faceCount_++] = {AxisKind::kFaceOfFirst, f, 0, -out, glm::dot(out, corner) - offset_m, corner};
      take(faces_[faceCount_ - 1], better_m);
      if (best_.kind == AxisKind::kFaceOfFirst) better_m = 0;
      if (best_.gap_m > way_.range_m) return;
    }
    better_m = kBetter_m;
    face_ = best_;
    for (std::uint8_t a = 0; a < first_.directions.size(); ++a) {
      const Vec3 along = frame_.rotate(first_.directions[a]);
      for (std::uint8_t b = 0; b < second_.directions.size(); ++b) {
        const Vec3 across = glm::cross(along, second_.directions[b]);
        const double sine = glm::length(across);
        if (sine < kParallel) continue;
        const Vec3 normal = across / sine;
        const auto gapAlong = [&](Vec3 n) {
          return glm::dot(n, leastOf(firstCorners(), n)) - glm::dot(n, leastOf(second_.corners, -n));
        };
        for (const Vec3 n : {normal, -normal}) {
          take({AxisKind::kEdges, a, b, n, gapAlong(n), {}}, better_m);
          if (best_.kind == AxisKind::kEdges) better_m = 0;
        }
        if (best_.gap_m > way_.range_m) return;
      }
    }
  }

  /// The best axis, which is a face's, or a face's that is to stand for it. Null: neither counts.
  [[nodiscard]] const Axis* levelAxis(bool& isOneOfTwo) const noexcept {
    LevelAxis level(way_, best_.normal, best_.gap_m, best_.nearest);
    const Axis* slowest = &best_;
    for (const Axis& axis : std::span(faces_).first(faceCount_)) {
      if (axis.gap_m < -way_.step_m || !level.mayTake(axis.normal)) continue;
      if (level.takes(axis.normal, axis.gap_m, axis.nearest)) slowest = &axis;
    }
    isOneOfTwo = level.isOneOfTwo();
    return level.isTied() ? nullptr : slowest;
  }

  void addFace(const Axis& axis, PolytopeContact& made) noexcept {
    made.ofSecond = axis.kind == AxisKind::kFaceOfFirst;
    const Polytope &ground = made.ofSecond ? first_ : second_, &other = made.ofSecond ? second_ : first_;
    const auto placeOf = [&](Polytope::Corner c, bool ofFirst) { return ofFirst ? corners_[c] : second_.corners[c]; };
    const auto normalOf = [&](const Polytope::Face& f, bool ofFirst) {
      return ofFirst ? frame_.rotate(f.normal) : f.normal;
    };
    const Polytope::Face& face = ground.faces[made.ofSecond ? axis.a : axis.b];
    const Vec3 normal = normalOf(face, made.ofSecond);
    const Polytope::Face& facing = *std::ranges::min_element(
        other.faces, {}, [&](const Polytope::Face& f) { return glm::dot(normalOf(f, !made.ofSecond), normal); });
    ClippedPolygon polygon;
    polygon.count = 0;
    for (const Polytope::Corner c : other.loopOf(facing))
      polygon.points[polygon.count++] = {c, placeOf(c, !made.ofSecond), {}, 0};
    const auto loop = ground.loopOf(face);
    polygon.clipTo(
        loop.size(), [&](std::size_t i) { return placeOf(loop[i], made.ofSecond); }, normal);
    const double offset_m = glm::dot(normal, placeOf(loop[0], made.ofSecond));
    for (std::size_t i = 0; i < polygon.count; ++i) {
      PolytopeContact::Point point = polygon.points[i];
      point.gap_m = glm::dot(normal, point.on) - offset_m;
      point.foot = point.on - point.gap_m * normal;
      if (point.gap_m <= way_.range_m) made.points[made.count++] = point;
    }
  }

  struct Segment {
    Vec3 from, to;
  };
  [[nodiscard]] Segment edgeOf(const Polytope::Edge& edge, bool ofFirst) const noexcept {
    return ofFirst ? Segment{corners_[edge.from], corners_[edge.to]}
                   : Segment{second_.corners[edge.from], second_.corners[edge.to]};
  }

  struct Nearest {
    Vec3 a, b;
  };
  /// Of two segments that are not parallel (Ericson, Real-Time Collision Detection, 2005, 5.1.9).
  [[nodiscard]] static Nearest nearestOf(const Segment& p, const Segment& q) noexcept {
    const Vec3 u = p.to - p.from, v = q.to - q.from, w = p.from - q.from;
    const double uu = squaredLength(u), vv = squaredLength(v), uv = glm::dot(u, v), uw = glm::dot(u, w),
                 vw = glm::dot(v, w), across = uu * vv - uv * uv;
    double s = across > 0 ? std::clamp((uv * vw - uw * vv) / across, 0.0, 1.0) : 0;
    const double t = std::clamp((uv * s + vw) / vv, 0.0, 1.0);
    s = std::clamp((uv * t - uw) / uu, 0.0, 1.0);
    return {p.from + s * u, q.from + t * v};
  }

  void addEdges(const Axis& axis, PolytopeContact& made) noexcept {
    const auto lowest = [&](const Polytope& of, std::uint8_t direction, bool ofFirst) {
      const Polytope::Edge* least = nullptr;
      double at = kInfinite;
      for (const Polytope::Edge& edge : of.edges) {
        if (edge.direction != direction) continue;
        const Segment segment = edgeOf(edge, ofFirst);
        const double here = glm::dot(segment.from + segment.to, ofFirst ? axis.normal : -axis.normal);
        if (here >= at) continue;
        at = here;
        least = &edge;
      }
      return least;
    };
    const Polytope::Edge &a = *lowest(first_, axis.a, true), &b = *lowest(second_, axis.b, false);
    const Nearest nearest = nearestOf(edgeOf(a, true), edgeOf(b, false));
    const double gap_m = glm::dot(axis.normal, nearest.a - nearest.b);
    if (gap_m <= way_.range_m) add(idOf(a, b), nearest.a, nearest.b, gap_m, made);
  }
  [[nodiscard]] std::uint32_t idOf(const Polytope::Edge& a, const Polytope::Edge& b) const noexcept {
    const auto numberOf = [](const Polytope& of, const Polytope::Edge& edge) {
      return static_cast<std::uint32_t>(&edge - of.edges.data());
    };
    return 1U << 19U | numberOf(first_, a) << 7U | numberOf(second_, b);
  }
  static void add(std::uint32_t id, Vec3 on, Vec3 foot, double gap_m, PolytopeContact& made) noexcept {
    made.ofSecond = false;  // also where a face of the first has met nothing
    made.points[made.count++] = {id, on, foot, gap_m};
  }

  /// Of two that are apart, and have no face above another: the closest of their edges, corners included.
  void addClosest(PolytopeContact& made) noexcept {
    const Vec3 out = best_.normal;
    const double first_m = glm::dot(out, leastOf(firstCorners(), out)),
                 second_m = glm::dot(out, leastOf(second_.corners, -out));
    double least = way_.range_m * way_.range_m;
    for (const Polytope::Edge& a : first_.edges) {
      const Segment edge = edgeOf(a, true);
      if (std::min(glm::dot(out, edge.from), glm::dot(out, edge.to)) > second_m + way_.range_m) continue;
      for (const Polytope::Edge& b : second_.edges) {
        const Segment other = edgeOf(b, false);
        if (std::max(glm::dot(out, other.from), glm::dot(out, other.to)) < first_m - way_.range_m) continue;
        const Nearest nearest = nearestOf(edge, other);
        const Vec3 apart = nearest.a - nearest.b;
        const double squared = squaredLength(apart);
        if (squared >= least || !(squared > 0)) continue;
        least = squared;
        made.count = 0;
        made.normal = apart / std::sqrt(squared);
        add(idOf(a, b), nearest.a, nearest.b, std::sqrt(squared), made);
      }
    }
  }
};

}  // namespace

namespace {

[[nodiscard]] std::int64_t unitsOfAxes(const Polytope& first, const Polytope& second) noexcept {
  constexpr std::int64_t kCorner = 2, kMeeting = 700;  // a corner along an axis; what follows the axes
  const auto size = [](const auto& list) { return static_cast<std::int64_t>(list.size()); };
  const std::int64_t onFaces = size(first.faces) * size(second.corners) + size(second.faces) * size(first.corners);
  const std::int64_t onEdges =
      2 * size(first.directions) * size(second.directions) * (size(first.corners) + size(second.corners));
  return kMeeting + kCorner * (onFaces + onEdges);
}

}  // namespace

PolytopeContact contactOf(const Polytope& first, const Polytope& second, const Pose& relative,
                          const PolytopeWay& way) noexcept {
  if (!first.hasFew() || !second.hasFew()) return contactOfRound(first, second, relative, way);
  PolytopeContact made = Meeting(first, second, relative, way).find();
  made.units = unitsOfAxes(first, second);
  return made;
}

double heightOver(const Polytope& polytope, const Frame& pose, const FlatPart& part, double range_m,
                  Polytope::Corner& nearest) noexcept {
  const double lowest_m = glm::dot(part.normal, pose.toWorld(polytope.middle) - part.corners[0]) - polytope.radius_m;
  if (lowest_m > range_m) return lowest_m;
  nearest = polytope.farthest(pose.toLocal(pose.origin - part.normal), nearest);
  return glm::dot(part.normal, pose.toWorld(polytope.corners[nearest]) - part.corners[0]);
}

}  // namespace haptics
