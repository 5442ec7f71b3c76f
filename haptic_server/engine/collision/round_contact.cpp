#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "haptic_server/engine/collision/clipped_polygon.h"
#include "haptic_server/engine/collision/level_axis.h"
#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics {
namespace {

/// The part of a simplex of differences (a place of the first body less one of the second) that is nearest to the origin.
class Simplex {
 public:
  struct Vertex {
    Vec3 apart, ofSecond;
  };

  Simplex() noexcept = default;
  /// Of two vertices at most one is kept, of three two, and so on, unless all are needed.
  void add(const Vertex& vertex) noexcept {
    vertices_[count_++] = vertex;
    if (count_ == 1) weights_[0] = 1;
    if (count_ == 2) *this = ofSegment(vertices_[0], vertices_[1]);
    if (count_ == 3) *this = ofTriangle(vertices_[0], vertices_[1], vertices_[2]);
    if (count_ == 4) *this = ofTetrahedron();
  }
  [[nodiscard]] bool holdsOrigin() const noexcept { return count_ == 4; }
  [[nodiscard]] bool has(Vec3 apart) const noexcept {
    return std::ranges::any_of(std::span(vertices_).first(count_), [&](const Vertex& v) { return v.apart == apart; });
  }
  [[nodiscard]] Vec3 nearest() const noexcept {
    Vec3 sum(0);
    for (std::size_t i = 0; i < count_; ++i) sum += weights_[i] * vertices_[i].apart;
    return sum;
  }
  [[nodiscard]] Vec3 ofSecond() const noexcept {
    Vec3 sum(0);
    for (std::size_t i = 0; i < count_; ++i) sum += weights_[i] * vertices_[i].ofSecond;
    return sum;
  }

 private:
  std::array<Vertex, 4> vertices_;
  std::array<double, 4> weights_;
  std::size_t count_ = 0;

  [[nodiscard]] static Simplex ofVertex(const Vertex& a) noexcept {
    Simplex made;
    made.add(a);
    return made;
  }
  [[nodiscard]] static Simplex between(const Vertex& a, const Vertex& b, double t) noexcept {
    Simplex made;
    made.vertices_ = {a, b, {}, {}};
    made.weights_ = {1 - t, t, 0, 0};
    made.count_ = 2;
    return made;
  }
  [[nodiscard]] static Simplex ofSegment(const Vertex& a, const Vertex& b) noexcept {
    const Vec3 along = b.apart - a.apart;
    const double t = -glm::dot(a.apart, along), whole = squaredLength(along);
    if (t <= 0) return ofVertex(a);
    return t >= whole ? ofVertex(b) : between(a, b, t / whole);
  }
  /// By Ericson, Real-Time Collision Detection, 2005, 5.1.5.
  [[nodiscard]] static Simplex ofTriangle(const Vertex& a, const Vertex& b, const Vertex& c) noexcept {
    const Vec3 ab = b.apart - a.apart, ac = c.apart - a.apart;
    const double d1 = -glm::dot(ab, a.apart), d2 = -glm::dot(ac, a.apart);
    if (d1 <= 0 && d2 <= 0) return ofVertex(a);
    const double d3 = -glm::dot(ab, b.apart), d4 = -glm::dot(ac, b.apart);
    if (d3 >= 0 && d4 <= d3) return ofVertex(b);
    const double overC = d1 * d4 - d3 * d2;
    if (overC <= 0 && d1 >= 0 && d3 <= 0) return between(a, b, d1 / (d1 - d3));
    const double d5 = -glm::dot(ab, c.apart), d6 = -glm::dot(ac, c.apart);
    if (d6 >= 0 && d5 <= d6) return ofVertex(c);
    const double overB = d5 * d2 - d1 * d6;
    if (overB <= 0 && d2 >= 0 && d6 <= 0) return between(a, c, d2 / (d2 - d6));
    const double overA = d3 * d6 - d5 * d4;
    if (overA <= 0 && d4 >= d3 && d5 >= d6) return between(b, c, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    Simplex made;
    const double whole = overA + overB + overC;
    made.vertices_ = {a, b, c, {}};
    made.weights_ = {overA / whole, overB / whole, overC / whole, 0};
    made.count_ = 3;
    return made;
  }
  [[nodiscard]] Simplex ofTetrahedron() const noexcept {
    const auto& [a, b, c, d] = vertices_;
    Simplex best = *this;
    double least = std::numeric_limits<double>::infinity();
    const auto look = [&](const Vertex& p, const Vertex& q, const Vertex& r, const Vertex& other) {
      const Vec3 normal = glm::cross(q.apart - p.apart, r.apart - p.apart);
      if (glm::dot(normal, other.apart - p.apart) * -glm::dot(normal, p.apart) > 0) return;  // the origin is inside
      const Simplex here = ofTriangle(p, q, r);
      const double squared = squaredLength(here.nearest());
      if (squared >= least) return;
      least = squared;
      best = here;
    };
    look(a, b, d, c);  // a, b and c alone are farther: d was taken because it is beyond them
    look(a, c, d, b);
    look(b, c, d, a);
    return best;
  }
};

/// A triangle, as what a polytope meets.
struct TriangleShape {
  struct Face {
    Vec3 normal;
    std::array<std::uint8_t, 3> loop;
  };
  const std::array<Vec3, 3>& corners;
  std::array<Face, 2> faces;
  double radius_m;
  Vec3 middle;

  /// @param nearest  Of the triangle to what it meets.
  TriangleShape(const FlatPart& part, Vec3 nearest) noexcept
      : corners(part.corners),
        faces{Face{part.normal, {0, 1, 2}}, Face{-part.normal, {0, 2, 1}}},
        radius_m(0),
        middle(nearest) {
    const Vec3 mean = (corners[0] + corners[1] + corners[2]) / 3.0;
    for (const Vec3 corner : corners) radius_m = std::max(radius_m, glm::distance(corner, mean));
  }
  [[nodiscard]] Polytope::Corner farthest(Vec3 along, Polytope::Corner) const noexcept {
    const double a = glm::dot(along, corners[0]), b = glm::dot(along, corners[1]), c = glm::dot(along, corners[2]);
    return b > a ? (c > b ? 2 : 1) : (c > a ? 2 : 0);
  }
  [[nodiscard]] Polytope::Corner nearFarthest(Vec3) const noexcept { return 0; }
  [[nodiscard]] const Face& facingAt(Polytope::Corner, Vec3 along) const noexcept {
    return faces[glm::dot(faces[0].normal, along) >= 0 ? 0 : 1];
  }
  [[nodiscard]] static std::span<const std::uint8_t> loopOf(const Face& face) noexcept { return face.loop; }
};

/// Two polytopes of which one has many faces, or a polytope and a triangle, in the second's frame.
template <class Second>
class RoundMeeting {
 public:
  RoundMeeting(const Polytope& first, const Second& second, const Pose& relative, const PolytopeWay& way) noexcept
      : first_(first), second_(second), frame_(relative), way_(way) {}

  /// False: they overlap by more than the tenth by which one is made smaller.
  [[nodiscard]] bool findApart() noexcept { return findApart(kShrunk) || findApart(kMuchShrunk); }
  /// The same, by as much more as bodies come into each other at an impact.
  [[nodiscard]] bool findDeepApart() noexcept { return findApart(kMaxShrunk); }
  /// Along the faces' normals.
  void findLeastDeep() noexcept {
    double best_m = -std::numeric_limits<double>::infinity();
    steps_ += static_cast<std::int64_t>(first_.faces.size() + second_.faces.size()) / 2;
    const auto take = [&](Vec3 normal, double gap_m, Vec3 place) {
      if (gap_m <= best_m || way_.isTurnedOver(normal)) return;
      best_m = gap_m;
      normal_ = normal;
      closest_ = ofFirst_ = place;
    };
    for (const Polytope::Face& face : second_.faces) {
      onFirst_ = first_.farthest(inFirst(-face.normal), onFirst_);
      const Vec3 corner = placeOfFirst(onFirst_);
      take(face.normal, glm::dot(face.normal, corner) - face.offset_m, corner);
    }
    for (const Polytope::Face& face : first_.faces) {
      const Vec3 out = frame_.rotate(face.normal);
      onSecond_ = second_.farthest(-out, onSecond_);
      const Vec3 corner = second_.corners[onSecond_];
      take(-out, glm::dot(out, corner - frame_.origin) - face.offset_m, corner);
    }
  }
  /// After findApart() or findLeastDeep(): turns to the axis that is to stand for the one found.
  void findLevel() noexcept {
    toSupports();
    if (gap_m_ > way_.range_m) return;
    const Vec3 found = normal_;
    if (gap_m_ < 0) {  // of those made smaller it may be another one
      visitAxes(found, [&](Vec3 normal, Vec3 place, auto heightOf, auto findNearest) noexcept {
        if (heightOf(place) <= gap_m_ || way_.isTurnedOver(normal)) return;
        ++steps_;
        const Vec3 nearest = findNearest();
        if (heightOf(nearest) <= gap_m_) return;
        gap_m_ = heightOf(nearest);
        normal_ = normal;
      });
    }
    const Vec3 best = normal_;
    LevelAxis level(way_, best, gap_m_, closest_);
    visitAxes(found, [&](Vec3 normal, Vec3 place, auto heightOf, auto findNearest) noexcept {
      if (!level.mayTake(normal) || heightOf(place) < -way_.step_m) return;
      ++steps_;
      const Vec3 nearest = findNearest();
      if (level.takes(normal, heightOf(nearest), nearest)) normal_ = normal;
    });
    isLevel_ = normal_ != best;
    isTied_ = level.isTied();
    isOneOfTwo_ = level.isOneOfTwo();
  }
  /// After findApart() or findLeastDeep().
  [[nodiscard]] PolytopeContact contact() noexcept {
    PolytopeContact made;
    toSupports();
    made.normal = normal_;
    made.gap_m = gap_m_;
    made.units = kMeeting + kStep * steps_;
    made.isOneOfTwo = isOneOfTwo_;
    if (gap_m_ > way_.range_m || isTied_) return made;
    addFaces(made);
    if (made.count == 0 && !isLevel_) {
      const Vec3 foot =
          closest_ + (glm::dot(normal_, second_.corners[onSecond_]) - glm::dot(normal_, closest_)) * normal_;
      made.points[made.count++] = {kOfClosest, foot + gap_m_ * normal_, foot, gap_m_};
    }
    return made;
  }

 private:
  /// The one with more faces is made smaller about its middle, by this part: bodies that rest are a little deep in each other.
  static constexpr double kShrunk = 0.01, kMuchShrunk = 0.1, kMaxShrunk = 0.3;
  static constexpr int kMaxSteps = 32;
  static constexpr std::int64_t kMeeting = 600, kStep = 200;  ///< Units.
  static constexpr double kConverged = 1e-3, kMinApart_m = 1e-9;
  /// Cosine of an axis and a face's normal that are one.
  static constexpr double kOneNormal = 1 - 1e-8;
  /// Places that are as near as the nearest ones, m: of edges that lie along each other.
  static constexpr double kAsNear_m = 2e-6;
  static constexpr std::uint32_t kOfClosest = PolytopeContact::kIds - 1;

  const Polytope& first_;
  const Second& second_;
  Frame frame_;
  const PolytopeWay& way_;
  Vec3 normal_{0};                ///< Out of the second.
  Vec3 closest_{0}, ofFirst_{0};  ///< The second's place that is nearest to the first, and the first's to it.
  double gap_m_ = 0;
  bool isLevel_ = false, isTied_ = false, isOneOfTwo_ = false;  ///< As findLevel() finds it.
  std::int64_t steps_ = 0;
  Polytope::Corner onFirst_ = 0, onSecond_ = 0;

  [[nodiscard]] Vec3 placeOfFirst(Polytope::Corner corner) const noexcept {
    return frame_.toWorld(first_.corners[corner]);
  }
  [[nodiscard]] Vec3 inFirst(Vec3 direction) const noexcept {
    return {glm::dot(frame_.x, direction), glm::dot(frame_.y, direction), glm::dot(frame_.z, direction)};
  }

  /// By Gilbert, Johnson and Keerthi (1988). False: they overlap.
  [[nodiscard]] bool findApart(double shrunk) noexcept {
    const bool shrinksFirst = first_.faces.size() >= second_.faces.size();
    const Vec3 middle = frame_.toWorld(first_.middle);
    const auto farthestApart = [&](Vec3 along) -> Simplex::Vertex {
      const Vec3 ofFirst = inFirst(-along);
      onFirst_ = first_.farthest(ofFirst, first_.nearFarthest(ofFirst));
      onSecond_ = second_.farthest(along, second_.nearFarthest(along));
      Vec3 a = placeOfFirst(onFirst_), b = second_.corners[onSecond_];
      if (shrinksFirst) {
        a = glm::mix(a, middle, shrunk);
      } else {
        b = glm::mix(b, second_.middle, shrunk);
      }
      return {a - b, b};
    };
    const double bound_m = way_.range_m + shrunk * (shrinksFirst ? first_.radius_m : second_.radius_m);
    Simplex simplex;
    Vec3 apart = way_.guess == Vec3(0) ? middle - second_.middle : way_.guess;
    if (squaredLength(apart) == 0) apart = Vec3(0, 0, 1);
    for (int step = 0; step < kMaxSteps; ++step) {
      ++steps_;
      const Simplex::Vertex vertex = farthestApart(apart);
      const double squared = squaredLength(apart), along = glm::dot(apart, vertex.apart);
      const bool isApart = step > 0 && (squared - along <= kConverged * squared || simplex.has(vertex.apart));
      const bool isFar = along > 0 && along * along > bound_m * bound_m * squared;
      if (isApart || isFar) {
        normal_ = apart / std::sqrt(squared);
        closest_ = step > 0 ? simplex.ofSecond() : vertex.ofSecond;
        ofFirst_ = closest_ + apart;
        return true;
      }
      simplex.add(vertex);
      apart = simplex.nearest();
      if (simplex.holdsOrigin() || !(squaredLength(apart) > kMinApart_m * kMinApart_m)) return false;
    }
    normal_ = glm::normalize(apart);
    closest_ = simplex.ofSecond();
    ofFirst_ = closest_ + apart;
    return true;
  }

  /// Shows the faces that meet the one which looks most along a direction, at its corners; of few faces all.
  template <class Look>
  static void visitFaces(const Polytope& of, Polytope::Corner corner, Vec3 along, Look look) noexcept {
    if (of.faces.size() <= Polytope::kFewFaces) {
      for (const Polytope::Face& face : of.faces) look(face);
      return;
    }
    for (const Polytope::Corner at : of.loopOf(of.facingAt(corner, along))) {
      for (const Polytope::Side& side : of.sidesOf(at)) look(of.faces[side.face]);
    }
  }

  /// Shows the faces about where the two are nearest along a direction: the normal out of the second, a place of the other body,
  /// its height over the face, and what finds the lowest such place.
  template <class Look>
  void visitAxes(Vec3 found, Look look) noexcept {
    visitFaces(second_, onSecond_, found, [&](const Polytope::Face& face) noexcept {
      look(
          face.normal, ofFirst_, [&](Vec3 at) { return glm::dot(face.normal, at) - face.offset_m; },
          [&] { return placeOfFirst(first_.farthest(inFirst(-face.normal), onFirst_)); });
    });
    visitFaces(first_, onFirst_, inFirst(-found), [&](const Polytope::Face& face) noexcept {
      const Vec3 out = frame_.rotate(face.normal);
      look(
          -out, closest_, [&](Vec3 at) { return glm::dot(out, at - frame_.origin) - face.offset_m; },
          [&] { return second_.corners[second_.farthest(-out, onSecond_)]; });
    });
  }

  void toSupports() noexcept {
    onFirst_ = first_.farthest(inFirst(-normal_), onFirst_);
    onSecond_ = second_.farthest(normal_, onSecond_);
    gap_m_ = glm::dot(normal_, placeOfFirst(onFirst_) - second_.corners[onSecond_]);
  }

  /// What of one's facing face is above the other's: what is as near as its nearest corner, or, along a face's normal, may be
  /// once the bodies have turned by what is within the range.
  void addFaces(PolytopeContact& made) noexcept {
    const auto& ofFirst = first_.facingAt(onFirst_, inFirst(-normal_));
    const auto& ofSecond = second_.facingAt(onSecond_, normal_);
    const Vec3 outFirst = frame_.rotate(ofFirst.normal);
    const double alongFirst = -glm::dot(outFirst, normal_), alongSecond = glm::dot(ofSecond.normal, normal_);
    made.ofSecond = alongFirst > alongSecond;
    const Vec3 out = made.ofSecond ? outFirst : ofSecond.normal;
    const bool isFaces = std::max(alongFirst, alongSecond) > kOneNormal;
    if (isFaces) made.normal = made.ofSecond ? -out : out;
    const auto placeOf = [&](Polytope::Corner corner, bool first) {
      return first ? placeOfFirst(corner) : second_.corners[corner];
    };
    ClippedPolygon polygon;
    const auto fill = [&](const auto& loop, bool first) {
      polygon.fill(loop.size(), [&](std::size_t i) { return placeOf(loop[i], first); });
    };
    const auto clip = [&](const auto& loop, bool first) {
      polygon.clipTo(
          loop.size(), [&](std::size_t i) { return placeOf(loop[i], first); }, out);
    };
    if (made.ofSecond) {
      fill(second_.loopOf(ofSecond), false);
      clip(first_.loopOf(ofFirst), true);
    } else {
      fill(first_.loopOf(ofFirst), true);
      clip(second_.loopOf(ofSecond), false);
    }
    const Vec3 up = made.ofSecond ? -made.normal : made.normal;  // off the ground
    const Vec3 ground = made.ofSecond ? placeOfFirst(onFirst_) : second_.corners[onSecond_];
    const auto corners = std::span(polygon.points).first(polygon.count);
    for (PolytopeContact::Point& corner : corners) corner.gap_m = glm::dot(up, corner.on - ground);
    const auto nearest = std::ranges::min_element(corners, {}, &PolytopeContact::Point::gap_m);
    const double turn = isFaces ? way_.range_m / std::min(first_.radius_m, second_.radius_m) : 0;
    for (PolytopeContact::Point& corner : corners) {
      const double reach_m = nearest->gap_m + kAsNear_m + turn * glm::distance(corner.on, nearest->on);
      if (corner.gap_m > std::min(reach_m, way_.range_m)) continue;
      corner.foot = corner.on - corner.gap_m * up;
      made.points[made.count++] = corner;
    }
    if (made.count == 0) {
      made.ofSecond = false;
      made.normal = normal_;
    }
  }
};

}  // namespace

PolytopeContact contactOfRound(const Polytope& first, const Polytope& second, const Pose& relative,
                               const PolytopeWay& way) noexcept {
  RoundMeeting meeting(first, second, relative, way);
  if (!meeting.findApart() && !meeting.findDeepApart()) meeting.findLeastDeep();
  meeting.findLevel();
  return meeting.contact();
}

std::optional<PolytopeContact> contactOf(const Polytope& polytope, const FlatPart& part, Vec3 nearest, const Pose& pose,
                                         double range_m) noexcept {
  const TriangleShape shape(part, nearest);
  const PolytopeWay way{.range_m = range_m};
  RoundMeeting meeting(polytope, shape, pose, way);
  if (!meeting.findApart()) return std::nullopt;
  return meeting.contact();
}

PolytopeContact contactOver(const Polytope& polytope, const Frame& pose, const FlatPart& part,
                            std::array<double, 2> range_m, Polytope::Corner nearest, bool areCorners) noexcept {
  constexpr std::int64_t kUnits = 40, kUnitsOfCorner = 20;
  PolytopeContact made;
  made.normal = part.normal;
  const Polytope::Face& facing = polytope.facingAt(nearest, pose.toLocal(pose.origin - part.normal));
  const auto loop = polytope.loopOf(facing);
  const auto& [a, b, c] = part.corners;
  const auto add = [&](std::uint32_t id, Vec3 on) noexcept {
    const double gap_m = glm::dot(part.normal, on - part.corners[0]);
    if (gap_m >= range_m[0] && gap_m <= range_m[1])
      made.points[made.count++] = {id, on, on - gap_m * part.normal, gap_m};
  };
  if (areCorners) {
    const Vec3 beyondAB = glm::cross(b - a, part.normal), beyondBC = glm::cross(c - b, part.normal),
               beyondCA = glm::cross(a - c, part.normal);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3 on = pose.toWorld(polytope.corners[loop[i]]);
      if (glm::dot(beyondAB, on - a) <= 0 && glm::dot(beyondBC, on - b) <= 0 && glm::dot(beyondCA, on - c) <= 0)
        add(static_cast<std::uint32_t>(i), on);
    }
    made.units = kUnits + kUnitsOfCorner * static_cast<std::int64_t>(loop.size());
    return made;
  }
  ClippedPolygon polygon;
  polygon.fill(loop.size(), [&](std::size_t i) { return pose.toWorld(polytope.corners[loop[i]]); });
  polygon.clipTo(
      part.corners.size(), [&](std::size_t i) { return part.corners[i]; }, part.normal);
  for (const auto& point : std::span(polygon.points).first(polygon.count)) add(point.id, point.on);
  made.units = kUnits + ClippedPolygon::kUnits * static_cast<std::int64_t>(loop.size());
  return made;
}

}  // namespace haptics
