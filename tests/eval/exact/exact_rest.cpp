#include "tests/eval/exact/exact_rest.h"

#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

namespace haptics::eval {
namespace {

using Kernel = CGAL::Simple_cartesian<CGAL::Exact_rational>;  // LGPL, as its number types are
using Number = Kernel::FT;
using Place = Kernel::Point_3;
using Way = Kernel::Vector_3;

Place toExact(Vec3 v) { return {Number(v.x), Number(v.y), Number(v.z)}; }
Vec3 toDouble(const Place& p) { return {CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())}; }
Way cross(const Way& a, const Way& b) { return CGAL::cross_product(a, b); }

struct Face {
  std::array<std::uint32_t, 3> vertex;
  Way normal;  ///< Outward, of any length.
};

/// Of an edge from `from` to `to`: the face that runs along it so, and the one that runs back.
struct Edge {
  std::uint32_t from, to;
  const Face* left;
  const Face* right;
};

class Surface {
 public:
  Surface(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles) {
    for (const Vec3f& v : vertices) places_.push_back(toExact(Vec3(v)));
    facesAt_.resize(vertices.size());
    edgesAt_.resize(vertices.size());
    for (const TriangleIndices& t : triangles)
      faces_.push_back({t, cross(places_[t[1]] - places_[t[0]], places_[t[2]] - places_[t[0]])});
    std::map<std::pair<std::uint32_t, std::uint32_t>, const Face*> along;
    for (const Face& face : faces_) {
      for (std::size_t k = 0; k < 3; ++k) {
        along[{face.vertex[k], face.vertex[(k + 1) % 3]}] = &face;
        facesAt_[face.vertex[k]].push_back({&face, k});
      }
    }
    for (const auto& [ends, face] : along) {
      const auto back = along.find({ends.second, ends.first});
      if (ends.first < ends.second && back != along.end())
        edges_.push_back({ends.first, ends.second, face, back->second});
    }
    for (const Edge& edge : edges_) {
      edgesAt_[edge.from].push_back(&edge);
      edgesAt_[edge.to].push_back(&edge);
    }
  }

  [[nodiscard]] std::vector<Place> restsFor(const Place& hip) const {
    std::vector<Place> rests;
    const auto keep = [&](const std::optional<Place>& place) {
      if (place) rests.push_back(*place);
    };
    for (const Face& face : faces_) keep(restWithin(face, hip));
    for (const Edge& edge : edges_) keep(restOn(edge, hip));
    for (std::uint32_t v = 0; v < places_.size(); ++v) keep(restAt(v, hip));
    return rests;
  }

 private:
  [[nodiscard]] std::optional<Place> restWithin(const Face& face, const Place& hip) const {
    const Place& a = places_[face.vertex[0]];
    const Number height = face.normal * (hip - a);
    if (height >= 0) return std::nullopt;
    const Place foot = hip - face.normal * (height / face.normal.squared_length());
    for (std::size_t k = 0; k < 3; ++k) {
      const Place& from = places_[face.vertex[k]];
      const Way edge = places_[face.vertex[(k + 1) % 3]] - from;
      if (cross(face.normal, edge) * (foot - from) <= 0) return std::nullopt;
    }
    return foot;
  }

  [[nodiscard]] std::optional<Place> restOn(const Edge& edge, const Place& hip) const {
    const Place& from = places_[edge.from];
    const Way way = places_[edge.to] - from;
    const Number part = way * (hip - from) / way.squared_length();
    if (part <= 0 || part >= 1) return std::nullopt;
    const Place foot = from + way * part;
    const Way pull = hip - foot;
    const bool leadsNearer = cross(edge.left->normal, way) * pull > 0 || cross(edge.right->normal, -way) * pull > 0;
    if (leadsNearer || isFree(pull, edge)) return std::nullopt;
    return foot;
  }

  [[nodiscard]] std::optional<Place> restAt(std::uint32_t vertex, const Place& hip) const {
    const Place& place = places_[vertex];
    const Way pull = hip - place;
    const Edge* nearest = nullptr;
    Number nearestCosine2;  // negative, times the pull's squared length
    for (const Edge* edge : edgesAt_[vertex]) {
      const Way way = places_[edge->from == vertex ? edge->to : edge->from] - place;
      const Number along = way * pull;
      if (along > 0) return std::nullopt;
      const Number cosine2 = -along * along / way.squared_length();
      if (nearest == nullptr || cosine2 > nearestCosine2) nearest = edge, nearestCosine2 = cosine2;
    }
    const Face* squarelyBelow = nullptr;
    for (const auto& [face, k] : facesAt_[vertex]) {
      const Way first = places_[face->vertex[(k + 1) % 3]] - place, second = places_[face->vertex[(k + 2) % 3]] - place;
      const Way along = pull - face->normal * (pull * face->normal / face->normal.squared_length());
      if (along == CGAL::NULL_VECTOR) {
        squarelyBelow = face;
      } else if (cross(face->normal, first) * along > 0 && cross(face->normal, second) * along < 0) {
        return std::nullopt;
      }
    }
    if (nearest == nullptr) return std::nullopt;
    const bool free = squarelyBelow != nullptr ? pull * squarelyBelow->normal > 0 : isFree(pull, *nearest);
    return free ? std::nullopt : std::optional(place);
  }

  /// Does it lead out of the wedge of the two faces?
  [[nodiscard]] bool isFree(const Way& pull, const Edge& edge) const {
    const bool aboveLeft = pull * edge.left->normal > 0, aboveRight = pull * edge.right->normal > 0;
    const Way inRight = cross(edge.right->normal, places_[edge.from] - places_[edge.to]);
    const Number rise = edge.left->normal * inRight;
    if (rise > 0) return aboveLeft && aboveRight;  // a valley
    return rise < 0 ? aboveLeft || aboveRight : aboveLeft;
  }

  std::vector<Place> places_;
  std::vector<Face> faces_;
  std::vector<Edge> edges_;
  std::vector<std::vector<std::pair<const Face*, std::size_t>>> facesAt_;
  std::vector<std::vector<const Edge*>> edgesAt_;
};

}  // namespace

std::vector<Vec3> exactRests(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles, Vec3 hip) {
  std::vector<Vec3> rests;
  for (const Place& place : Surface(vertices, triangles).restsFor(toExact(hip))) rests.push_back(toDouble(place));
  return rests;
}

}  // namespace haptics::eval
