#include "common/mesh/decimation.h"

// QuadricT.hh does not include what it needs.
// clang-format off
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Geometry/QuadricT.hh>
// clang-format on
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/interruption/interruption.h"
#include "common/mesh/import.h"
#include "common/mesh/triangle_distance.h"

namespace haptics {
namespace {

double squared(double value) { return value * value; }

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status);
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Point = Mesh::Point;
using Corners = std::array<Vec3, 3>;
using Quadric = OpenMesh::Geometry::QuadricT<double>;

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Cosine of the angle by which a triangle may turn in one collapse. Larger keeps more triangles; below 0 the surface folds.
constexpr double kMinTurnCosine = 0.2;
/// Twice the area over the square of the longest side, below which a triangle may only become better.
constexpr double kSliver = 1e-3;
/// As many as a quadric sums, so that a place off the surface costs as much as the planes that are missed by as far.
constexpr double kPlanes = 10;
/// Of the vertices that are left, those that one sweep tries to take away. Larger is quicker, and keeps worse vertices.
constexpr double kPerSweep = 0.25;

double longestSide_m(const TriMesh& mesh) {
  Vec3f low = mesh.vertices.front(), high = low;
  for (const Vec3f v : mesh.vertices) {
    low = glm::min(low, v);
    high = glm::max(high, v);
  }
  const Vec3 size = Vec3(high) - Vec3(low);
  return std::max({size.x, size.y, size.z});
}

double shapeOf(const Corners& corner, double twiceArea) {
  const double longest = std::max({squaredLength(corner[1] - corner[0]), squaredLength(corner[2] - corner[1]),
                                   squaredLength(corner[0] - corner[2])});
  return twiceArea / longest;
}

}  // namespace

/// Collapses edges and notes them.
class Decimation::Sweeper {
 public:
  explicit Sweeper(Decimation& decimation)
      : to_(decimation),
        source_(decimation.mesh_),
        // of points that lie in the planes but for rounding, even where many meet
        exactCost_(squared(kExact_of_longest * longestSide_m(source_))) {
    build();
    sumQuadrics();
    strayed_m_.assign(source_.vertices.size(), 0);
    cost_.assign(source_.vertices.size(), 0);
    alive_.resize(source_.vertices.size());
    std::iota(alive_.begin(), alive_.end(), 0);
    std::erase_if(alive_, [&](std::uint32_t v) { return !mayGo(v); });
    for (const std::uint32_t v : alive_) cost_[v] = cheapestOf(v);
  }

  void run() {
    while (sweep(exactCost_) > 0) continue;
    to_.exact_ = left_;
    std::vector<double> costs;
    while (true) {
      costs.clear();
      for (const std::uint32_t v : alive_) {
        if (cost_[v] < kNever) costs.push_back(cost_[v]);
      }
      if (costs.empty()) return;
      const auto at = costs.begin() + static_cast<std::ptrdiff_t>(kPerSweep * static_cast<double>(costs.size()));
      std::nth_element(costs.begin(), at, costs.end());
      sweep(*at);
    }
  }

 private:
  struct Choice {
    double cost;
    Mesh::HalfedgeHandle halfEdge;
  };

  Decimation& to_;
  const TriMesh& source_;
  const double exactCost_;
  Mesh mesh_;
  std::size_t left_ = 0;
  std::vector<Quadric> quadric_;
  std::vector<double> strayed_m_;  // of each vertex, how far those at most are from it or its faces that it stands for
  std::vector<bool> locked_;
  std::vector<std::uint32_t> alive_;
  std::vector<double> cost_;  // of each vertex, when it was last looked at; kNever until its neighbours change
  std::vector<Choice> choices_;

  void build() {
    omerr().disable();  // a line for each face that is not manifold
    mesh_.reserve(source_.vertices.size(), 3 * source_.triangles.size() / 2, source_.triangles.size());
    for (const Vec3f v : source_.vertices) mesh_.add_vertex(Point(v.x, v.y, v.z));
    locked_.resize(source_.vertices.size());
    for (const TriangleIndices& t : source_.triangles) {
      interruptionPoint();
      const auto corner = [&](std::size_t k) { return OpenMesh::VertexHandle(static_cast<int>(t[k])); };
      if (mesh_.add_face(corner(0), corner(1), corner(2)).is_valid()) continue;
      for (const std::uint32_t v : t) locked_[v] = true;
    }
    left_ = source_.triangles.size();
    to_.trianglesAfter_ = {static_cast<std::uint32_t>(left_)};
  }

  [[nodiscard]] bool mayGo(std::uint32_t v) const {
    const Mesh::VertexHandle vertex(static_cast<int>(v));
    return !locked_[v] && mesh_.is_manifold(vertex) && !mesh_.is_isolated(vertex);
  }

  [[nodiscard]] Vec3 placeOf(Mesh::VertexHandle vertex) const {
    const Point& place = mesh_.point(vertex);
    return {place[0], place[1], place[2]};
  }

  [[nodiscard]] Point normalOf(Mesh::FaceHandle face) const {
    Corners corners;
    auto halfEdge = mesh_.halfedge_handle(face);
    for (Vec3& corner : corners) {
      corner = placeOf(mesh_.to_vertex_handle(halfEdge));
      halfEdge = mesh_.next_halfedge_handle(halfEdge);
    }
    const Vec3 normal = glm::normalize(areaNormal(corners));
    return {normal.x, normal.y, normal.z};
  }

  void addPlane(Mesh::VertexHandle vertex, const Point& normal, const Point& place) {
    quadric_[static_cast<std::size_t>(vertex.idx())] += Quadric(normal, place);
  }

  /// The planes of the faces around each vertex, and through each boundary the plane across its face.
  void sumQuadrics() {
    quadric_.resize(source_.vertices.size());
    for (const auto face : mesh_.faces()) {
      interruptionPoint();
      const Point normal = normalOf(face);
      for (const auto halfEdge : face.halfedges()) {
        const Point place = mesh_.point(halfEdge.to());
        addPlane(halfEdge.to(), normal, place);
        if (!halfEdge.opp().is_boundary()) continue;
        const Point across = cross(place - mesh_.point(halfEdge.from()), normal).normalized();
        addPlane(halfEdge.from(), across, place);
        addPlane(halfEdge.to(), across, place);
      }
    }
  }

  /// Sum of the squared distances to the planes of both vertices; of equal ones, as on what is flat, the shorter edge's.
  [[nodiscard]] double costOf(Mesh::HalfedgeHandle halfEdge) const {
    constexpr double kLength = 1e-14;
    const auto from = mesh_.from_vertex_handle(halfEdge), to = mesh_.to_vertex_handle(halfEdge);
    const Point place = mesh_.point(to);
    const double error =
        quadric_[static_cast<std::size_t>(from.idx())](place) + quadric_[static_cast<std::size_t>(to.idx())](place);
    return std::max(error, 0.0) + kLength * (place - mesh_.point(from)).sqrnorm();
  }

  [[nodiscard]] double cheapestOf(std::uint32_t v) const {
    double cheapest = kNever;
    const Mesh::VertexHandle vertex(static_cast<int>(v));
    for (auto at = mesh_.cvoh_iter(vertex); at.is_valid(); ++at) cheapest = std::min(cheapest, costOf(*at));
    return cheapest;
  }

  [[nodiscard]] bool isAllowed(Mesh::HalfedgeHandle collapse) {
    const auto from = mesh_.from_vertex_handle(collapse), to = mesh_.to_vertex_handle(collapse);
    if (mesh_.is_boundary(from) && !mesh_.is_boundary(mesh_.edge_handle(collapse))) return false;
    return mesh_.is_collapse_ok(collapse) && keepsShape(from, to);
  }

  /// Corners of the faces that stay around a vertex: as they are, and as they are when it has gone to another.
  template <class Visit>
  void visitFaces(Mesh::VertexHandle from, Mesh::VertexHandle to, Visit visit) const {
    const Vec3 place = placeOf(to);
    for (auto at = mesh_.cvoh_iter(from); at.is_valid(); ++at) {
      if (!mesh_.face_handle(*at).is_valid()) continue;
      const auto second = mesh_.to_vertex_handle(*at);
      const auto third = mesh_.to_vertex_handle(mesh_.next_halfedge_handle(*at));
      if (second == to || third == to) continue;
      const Corners now{placeOf(from), placeOf(second), placeOf(third)};
      if (!visit(now, Corners{place, now[1], now[2]})) return;
    }
  }

  /// No triangle turns too far, or gets too thin.
  [[nodiscard]] bool keepsShape(Mesh::VertexHandle from, Mesh::VertexHandle to) const {
    bool keeps = true;
    visitFaces(from, to, [&](const Corners& now, const Corners& then) {
      const Vec3 before = areaNormal(now), after = areaNormal(then);
      const double areaBefore = glm::length(before), areaAfter = glm::length(after);
      const double shape = shapeOf(then, areaAfter);
      const bool turns = glm::dot(before, after) <= kMinTurnCosine * areaBefore * areaAfter;
      return keeps = !turns && (shape >= kSliver || shape > shapeOf(now, areaBefore));
    });
    return keeps;
  }

  /// How far what `from` stands for is at most from the surface when it has gone.
  [[nodiscard]] double strayOf(Mesh::HalfedgeHandle collapse) const {
    const auto from = mesh_.from_vertex_handle(collapse), to = mesh_.to_vertex_handle(collapse);
    const Vec3 place = placeOf(from);
    double least = squaredLength(place - placeOf(to));
    visitFaces(from, to, [&](const Corners&, const Corners& then) {
      least = std::min(least, squaredDistance(place, then));
      return true;
    });
    return strayed_m_[static_cast<std::size_t>(from.idx())] + std::sqrt(least);
  }

  /// The cheapest collapse that is allowed; cost kNever where there is none.
  Choice choose(Mesh::VertexHandle vertex) {
    choices_.clear();
    for (auto at = mesh_.cvoh_iter(vertex); at.is_valid(); ++at) choices_.push_back({costOf(*at), *at});
    std::ranges::stable_sort(choices_, {}, &Choice::cost);
    Choice best{kNever, Mesh::HalfedgeHandle()};
    for (const Choice& choice : choices_) {
      if (choice.cost >= best.cost) break;
      if (!isAllowed(choice.halfEdge)) continue;
      const double cost = std::max(choice.cost, kPlanes * squared(strayOf(choice.halfEdge)));
      if (cost < best.cost) best = {cost, choice.halfEdge};
    }
    return best;
  }

  void collapse(Mesh::HalfedgeHandle halfEdge) {
    const auto from = mesh_.from_vertex_handle(halfEdge), to = mesh_.to_vertex_handle(halfEdge);
    const double stray_m = strayOf(halfEdge);
    left_ -= mesh_.is_boundary(mesh_.edge_handle(halfEdge)) ? 1 : 2;
    mesh_.collapse(halfEdge);
    double& strayed_m = strayed_m_[static_cast<std::size_t>(to.idx())];
    strayed_m = std::max(strayed_m, stray_m);
    quadric_[static_cast<std::size_t>(to.idx())] += quadric_[static_cast<std::size_t>(from.idx())];
    to_.collapses_.push_back({static_cast<std::uint32_t>(from.idx()), static_cast<std::uint32_t>(to.idx())});
    to_.trianglesAfter_.push_back(static_cast<std::uint32_t>(left_));
    lookAgain(to);
    for (auto at = mesh_.cvv_iter(to); at.is_valid(); ++at) lookAgain(*at);
  }

  void lookAgain(Mesh::VertexHandle vertex) {
    const auto v = static_cast<std::uint32_t>(vertex.idx());
    cost_[v] = locked_[v] ? kNever : cheapestOf(v);
  }

  /// Takes away the vertices that cost no more; returns how many.
  std::size_t sweep(double most) {
    const std::size_t before = to_.collapses_.size();
    for (const std::uint32_t v : alive_) {
      if (cost_[v] > most) continue;
      interruptionPoint();
      const Mesh::VertexHandle vertex(static_cast<int>(v));
      const Choice choice = choose(vertex);
      cost_[v] = choice.cost;
      if (choice.cost <= most) collapse(choice.halfEdge);
    }
    std::erase_if(alive_,
                  [&](std::uint32_t v) { return mesh_.status(Mesh::VertexHandle(static_cast<int>(v))).deleted(); });
    return to_.collapses_.size() - before;
  }
};

Decimation::Decimation(const TriMesh& mesh) : mesh_(mesh), exact_(mesh.triangles.size()) { Sweeper(*this).run(); }

TriMesh Decimation::copyOf(std::size_t triangles) const {
  const auto at = std::ranges::lower_bound(trianglesAfter_, triangles, std::greater());
  const auto collapses = std::min(collapses_.size(), static_cast<std::size_t>(at - trianglesAfter_.begin()));
  std::vector<std::uint32_t> stands(mesh_.vertices.size());  // for each vertex, the one that has taken its place
  std::iota(stands.begin(), stands.end(), 0);
  for (std::size_t i = collapses; i-- > 0;) {
    const auto& [from, to] = collapses_[i];
    stands[from] = stands[to];
  }
  std::vector<TriangleIndices> left;
  for (const TriangleIndices& t : mesh_.triangles) {
    interruptionPoint();
    const TriangleIndices moved{stands[t[0]], stands[t[1]], stands[t[2]]};
    if (moved[0] != moved[1] && moved[1] != moved[2] && moved[2] != moved[0]) left.push_back(moved);
  }
  const std::vector<Vec3> vertices(mesh_.vertices.begin(), mesh_.vertices.end());
  return canonicalise(vertices, std::move(left), {}).value().mesh;
}

}  // namespace haptics
