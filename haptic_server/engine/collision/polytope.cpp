#include "haptic_server/engine/collision/polytope.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <set>

#include "common/interruption/interruption.h"
#include "haptic_server/engine/geometry/spaced_points.h"

namespace haptics {
namespace {

/// Of the mesh's extent: as far as float32 corners of one flat face are off its plane.
constexpr double kFlat = 1e-6;
/// Cosine of two normals of one flat face; the planes' distance decides.
constexpr double kSameFace = 0.999;
/// Sine below which two edges share a direction.
constexpr double kOneDirection = 1e-4;

/// The flat parts of a mesh. Object frame.
class FlatFaces {
 public:
  struct Plane {
    Vec3 normal;
    double offset_m;
  };

  explicit FlatFaces(const CollisionMesh& mesh)
      : mesh_(mesh), rounding_m_(kFlat * mesh.extent_m()), faceOf_(mesh.triangleCount(), kNone) {}

  /// False: there are too many, or some part is behind another.
  [[nodiscard]] bool find() {
    for (std::uint32_t t = 0; t < mesh_.triangleCount(); ++t) {
      interruptionPoint();
      if (faceOf_[t] != kNone) continue;
      if (planes_.size() == Polytope::kMaxFaces) return false;
      planes_.push_back({mesh_.faceNormal(t), glm::dot(mesh_.faceNormal(t), mesh_.triangle(t).corner(0))});
      spread(t);
    }
    for (std::uint32_t t = 0; t < mesh_.triangleCount(); ++t) {
      interruptionPoint();
      for (int k = 0; k < 3; ++k) {
        const Vec3 corner = mesh_.triangle(t).corner(k);
        const auto isAbove = [&](const Plane& p) { return glm::dot(p.normal, corner) > p.offset_m + rounding_m_; };
        if (std::ranges::any_of(planes_, isAbove)) return false;
      }
    }
    return true;
  }

  [[nodiscard]] std::span<const Plane> planes() const { return planes_; }
  /// Where three faces or more meet, and which do.
  [[nodiscard]] std::map<std::array<double, 3>, std::set<Polytope::FaceIndex>> corners() const {
    std::map<std::array<double, 3>, std::set<Polytope::FaceIndex>> all;
    for (std::uint32_t t = 0; t < mesh_.triangleCount(); ++t) {
      interruptionPoint();
      for (int k = 0; k < 3; ++k) {
        const Vec3 corner = mesh_.triangle(t).corner(k);
        all[{corner.x, corner.y, corner.z}].insert(faceOf_[t]);
      }
    }
    std::erase_if(all, [](const auto& corner) { return corner.second.size() < 3; });
    return all;
  }

 private:
  static constexpr Polytope::FaceIndex kNone = 65'535;
  const CollisionMesh& mesh_;
  double rounding_m_;
  std::vector<Polytope::FaceIndex> faceOf_;
  std::vector<Plane> planes_;

  void spread(std::uint32_t from) {
    const auto face = static_cast<Polytope::FaceIndex>(planes_.size() - 1);
    std::vector<std::uint32_t> open{from};
    faceOf_[from] = face;
    while (!open.empty()) {
      interruptionPoint();
      const TriangleRecord& triangle = mesh_.triangle(open.back());
      open.pop_back();
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t next = triangle.neighbour(k);
        if (next == kNoTriangle || faceOf_[next] != kNone || !isIn(next, planes_[face])) continue;
        faceOf_[next] = face;
        open.push_back(next);
      }
    }
  }
  [[nodiscard]] bool isIn(std::uint32_t t, const Plane& plane) const {
    if (glm::dot(mesh_.faceNormal(t), plane.normal) < kSameFace) return false;
    return std::ranges::all_of(std::array{0, 1, 2}, [&](int k) {
      return std::abs(glm::dot(plane.normal, mesh_.triangle(t).corner(k)) - plane.offset_m) <= rounding_m_;
    });
  }
};

/// Counterclockwise about the normal.
void sortAround(std::span<Polytope::Corner> loop, const std::vector<Vec3>& corners, Vec3 normal) {
  Vec3 middle(0);
  for (const Polytope::Corner c : loop) middle += corners[c] / static_cast<double>(loop.size());
  const Vec3 x = corners[loop[0]] - middle, y = glm::cross(normal, x);
  std::ranges::sort(loop, {}, [&](Polytope::Corner c) {
    const Vec3 arm = corners[c] - middle;
    const double across = glm::dot(arm, y), along = glm::dot(arm, x);  // order of the angle, without its value
    const double part = along / (std::abs(along) + std::abs(across));
    return across < 0 ? 3 + part : 1 - part;
  });
}

/// Without them where there are too many directions.
void addEdges(Polytope& made) {
  std::set<std::array<Polytope::Corner, 2>> seen;
  for (const Polytope::Face& face : made.faces) {
    const auto loop = made.loopOf(face);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Polytope::Corner a = loop[i], b = loop[(i + 1) % loop.size()];
      if (!seen.insert({std::min(a, b), std::max(a, b)}).second) continue;
      const Vec3 along = glm::normalize(made.corners[b] - made.corners[a]);
      const auto same = std::ranges::find_if(made.directions,
                                             [&](Vec3 d) { return glm::length(glm::cross(d, along)) < kOneDirection; });
      const auto direction = static_cast<std::uint8_t>(same - made.directions.begin());
      if (same == made.directions.end()) made.directions.push_back(along);
      made.edges.push_back({a, b, direction});
      if (made.directions.size() <= Polytope::kFewDirections) continue;
      made.edges.clear();
      made.directions.clear();
      return;
    }
  }
}

void addSides(Polytope& made) {
  std::vector<std::vector<Polytope::Side>> sides(made.corners.size());
  for (std::size_t f = 0; f < made.faces.size(); ++f) {
    const auto loop = made.loopOf(made.faces[f]);
    for (std::size_t i = 0; i < loop.size(); ++i)
      sides[loop[i]].push_back({loop[(i + 1) % loop.size()], static_cast<Polytope::FaceIndex>(f)});
  }
  for (const auto& own : sides) {
    made.around.push_back(static_cast<std::uint32_t>(made.sides.size()));
    made.sides.insert(made.sides.end(), own.begin(), own.end());
  }
  made.around.push_back(static_cast<std::uint32_t>(made.sides.size()));
}

void setBegins(Polytope& made) {
  constexpr int kCells = Polytope::kCellsOfSide;
  const auto middleOf = [](int cell) { return (cell + 0.5) * 2 / kCells - 1; };
  Polytope::Corner last = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      for (int next = 0; next < kCells; ++next) {
        for (int previous = 0; previous < kCells; ++previous) {
          Vec3 along;
          along[axis] = sign;
          along[nextCorner(axis)] = middleOf(next);
          along[previousCorner(axis)] = middleOf(previous);
          made.begins[Polytope::cellOf(along)] = last = made.farthest(along, last);
        }
      }
    }
  }
}

}  // namespace

Polytope::Corner Polytope::farthest(Vec3 along, Corner from) const noexcept {
  double at = glm::dot(along, corners[from]);
  for (Corner last = from;; last = from) {
    for (const Side& side : sidesOf(last)) {
      if (const double here = glm::dot(along, corners[side.corner]); here > at) {
        at = here;
        from = side.corner;
      }
    }
    if (from == last) return from;
  }
}

const Polytope::Face& Polytope::facingAt(Corner corner, Vec3 along) const noexcept {
  const auto own = sidesOf(corner);
  return faces[std::ranges::max_element(own, {}, [&](const Side& s) {
                 return glm::dot(faces[s.face].normal, along);
               })->face];
}

Polytope::Above Polytope::above(Vec3 at, Corner& near) const noexcept {
  Above best{nullptr, -std::numeric_limits<double>::infinity()};
  const auto take = [&](const Face& face) {
    const double height_m = glm::dot(face.normal, at) - face.offset_m;
    if (height_m > best.height_m) best = {&face, height_m};
  };
  if (faces.size() <= kFewFaces) {
    std::ranges::for_each(faces, take);
    return best;
  }
  near = farthest(at - middle, near);
  for (const Side& side : sidesOf(near)) take(faces[side.face]);
  for (const Face* last = nullptr; last != best.face;) {
    last = best.face;
    for (const Corner corner : loopOf(*last)) {
      for (const Side& side : sidesOf(corner)) take(faces[side.face]);
    }
  }
  return best;
}

std::optional<Polytope> polytopeOf(const CollisionMesh& mesh) {
  FlatFaces flat(mesh);
  if (!mesh.closed() || !flat.find()) return std::nullopt;
  const auto corners = flat.corners();
  if (corners.size() > Polytope::kMaxCorners || corners.empty()) return std::nullopt;
  Polytope made;
  std::vector<std::vector<Polytope::Corner>> loops(flat.planes().size());
  for (const auto& [place, faces] : corners) {
    for (const Polytope::FaceIndex f : faces) loops[f].push_back(static_cast<Polytope::Corner>(made.corners.size()));
    made.corners.emplace_back(place[0], place[1], place[2]);
    made.middle += made.corners.back() / static_cast<double>(corners.size());
  }
  bool isFew = loops.size() <= Polytope::kFewFaces && corners.size() <= Polytope::kFewCorners;
  for (std::size_t f = 0; f < loops.size(); ++f) {
    auto& loop = loops[f];
    if (loop.size() < 3 || loop.size() > Polytope::kMaxOfFace) return std::nullopt;
    isFew = isFew && loop.size() <= Polytope::kFewOfFace;
    sortAround(loop, made.corners, flat.planes()[f].normal);
    Polytope::Face face{flat.planes()[f].normal, -std::numeric_limits<double>::infinity(),
                        static_cast<std::uint32_t>(made.loops.size()), 0};
    for (const Polytope::Corner k : loop)
      face.offset_m = std::max(face.offset_m, glm::dot(face.normal, made.corners[k]));
    made.loops.insert(made.loops.end(), loop.begin(), loop.end());
    face.end = static_cast<std::uint32_t>(made.loops.size());
    made.faces.push_back(face);
  }
  const bool isOne = made.corners.size() + made.faces.size() == made.loops.size() / 2 + 2;  // Euler's characteristic
  if (!isOne) return std::nullopt;
  for (const Vec3 corner : made.corners) made.radius_m = std::max(made.radius_m, glm::distance(corner, made.middle));
  addSides(made);
  setBegins(made);
  if (isFew) addEdges(made);
  return made;
}

namespace {

/// The convex hull, a place after the other.
class Hull {
 public:
  using Triangle = std::array<std::uint32_t, 3>;

  /// @param rounding_m  A place that is outside by less is inside.
  Hull(std::span<const Vec3> places, double rounding_m) : places_(places), rounding_m_(rounding_m) {
    if (!begin()) return;
    for (std::uint32_t p = 0; p < places.size(); ++p) add(p);
  }

  /// Empty: the places are on one plane.
  [[nodiscard]] std::vector<Triangle> triangles() const {
    std::vector<Triangle> all;
    for (const Side& side : sides_) all.push_back(side.corners);
    return all;
  }

 private:
  struct Side {
    Triangle corners;
    Vec3 normal;
    double offset_m;
  };
  std::span<const Vec3> places_;
  double rounding_m_;
  std::vector<Side> sides_;

  void addSide(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Vec3 normal = unitOrZero(glm::cross(places_[b] - places_[a], places_[c] - places_[a]));
    sides_.push_back({{a, b, c}, normal, glm::dot(normal, places_[a])});
  }
  /// A tetrahedron of places that are far apart.
  [[nodiscard]] bool begin() {
    const auto farthest = [&](auto distance) {
      const auto at = std::ranges::max_element(places_, {}, distance);
      return static_cast<std::uint32_t>(at - places_.begin());
    };
    const std::uint32_t a = farthest([](Vec3 p) { return p.x; });
    const std::uint32_t b = farthest([&](Vec3 p) { return squaredLength(p - places_[a]); });
    const Vec3 along = unitOrZero(places_[b] - places_[a]);
    const std::uint32_t c = farthest([&](Vec3 p) { return squaredLength(glm::cross(along, p - places_[a])); });
    const Vec3 normal = unitOrZero(glm::cross(along, places_[c] - places_[a]));
    const std::uint32_t d = farthest([&](Vec3 p) { return std::abs(glm::dot(normal, p - places_[a])); });
    const double height_m = glm::dot(normal, places_[d] - places_[a]);
    if (!(std::abs(height_m) > rounding_m_)) return false;
    const std::uint32_t e = height_m < 0 ? b : c, f = height_m < 0 ? c : b;
    addSide(a, e, f);
    addSide(a, d, e);
    addSide(e, d, f);
    addSide(f, d, a);
    return true;
  }
  void add(std::uint32_t p) {
    std::set<std::array<std::uint32_t, 2>> border;  // of what is seen from the place
    const auto isSeen = [&](const Side& side) {
      return glm::dot(side.normal, places_[p]) > side.offset_m + rounding_m_;
    };
    for (const Side& side : sides_) {
      if (!isSeen(side)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = side.corners[k], to = side.corners[(k + 1) % 3];
        if (border.erase({to, from}) == 0) border.insert({from, to});
      }
    }
    if (border.empty()) return;
    std::erase_if(sides_, isSeen);
    for (const auto& [from, to] : border) addSide(from, to, p);
  }
};

/// As far apart as leaves no more of them than a polytope may have.
[[nodiscard]] std::vector<Vec3> spacedVertices(const CollisionMesh& mesh) {
  constexpr double kWider = 1.25;
  for (double spacing_m = kHullSpacing * mesh.radius_m();; spacing_m *= kWider) {
    SpacedPoints points(spacing_m);
    for (std::uint32_t t = 0; t < mesh.triangleCount() && points.size() <= Polytope::kMaxCorners; ++t) {
      interruptionPoint();
      for (int k = 0; k < 3; ++k) points.add(mesh.triangle(t).corner(k));
    }
    if (points.size() <= Polytope::kMaxCorners) return points.take();
  }
}

/// The middles of the mesh's lines and its vertices are as near to the polytope's surface.
[[nodiscard]] bool isWithin(const CollisionMesh& mesh, const Polytope& polytope, double error_m) {
  Polytope::Corner near = 0;
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    interruptionPoint();
    for (int k = 0; k < 3; ++k) {
      const Vec3 from = mesh.triangle(t).corner(k), to = mesh.triangle(t).corner(nextCorner(k));
      for (const Vec3 at : {from, (from + to) / 2.0}) {
        if (std::abs(polytope.above(at, near).height_m) > error_m) return false;
      }
    }
  }
  return true;
}

}  // namespace

std::optional<Polytope> hullOf(const CollisionMesh& mesh) {
  if (!mesh.closed()) return std::nullopt;
  const std::vector<Vec3> places = spacedVertices(mesh);
  const std::vector<Hull::Triangle> triangles = Hull(places, kFlat * mesh.extent_m()).triangles();
  if (triangles.empty()) return std::nullopt;
  std::vector<Vec3f> vertices;
  for (const Vec3 place : places) vertices.emplace_back(place);
  std::optional<Polytope> made = polytopeOf(*buildCollisionMesh(vertices, triangles));
  if (made && !isWithin(mesh, *made, kHullError * mesh.radius_m())) made.reset();
  return made;
}

}  // namespace haptics
