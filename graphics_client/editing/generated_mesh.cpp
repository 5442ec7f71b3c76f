#include "graphics_client/editing/generated_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "common/importer/mesh_recipe.h"

namespace haptics {
namespace {

/// The number of fewest decimal digits near the estimate for which `makes` gives this float; the estimate if there is none.
template <class Makes>
double shortest(double estimate, float wanted, Makes makes) {
  constexpr int kMaxDigits = 12;
  for (int digits = 1; digits <= kMaxDigits; ++digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, estimate);
    const double number = std::strtod(text, nullptr);
    if (static_cast<float>(makes(number)) == wanted) return number;
  }
  return estimate;
}

double half(double size) { return size / 2; }
double same(double size) { return size; }

/// Whole n with n * n == square; 0: there is none.
std::uint32_t rootOf(std::size_t square) {
  const auto root = static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(square))));
  return std::size_t{root} * root == square ? root : 0;
}

class Recogniser {
 public:
  explicit Recogniser(const TriMesh& mesh) : mesh_(mesh) {
    for (const Vec3f vertex : mesh.vertices) high_ = glm::max(high_, vertex);
  }

  [[nodiscard]] std::optional<v1::MeshSource> recognised() const {
    if (!(high_.x > 0 && high_.y > 0 && high_.z > 0)) return std::nullopt;
    for (const auto attempt : {&Recogniser::box, &Recogniser::sphere, &Recogniser::cylinder, &Recogniser::torus}) {
      if (auto source = (this->*attempt)()) return source;
    }
    return std::nullopt;
  }

 private:
  const TriMesh& mesh_;
  Vec3f high_{0};

  [[nodiscard]] bool isMadeBy(const MeshRecipe& recipe) const {
    if (trianglesOf(recipe) != static_cast<double>(mesh_.triangles.size())) return false;
    const auto made = generate(recipe);
    return made && *made == mesh_;
  }

  /// Of a cube's edge, in meshes that are grids on a cube; 0: it is none of them.
  [[nodiscard]] std::uint32_t gridSegments() const {
    const std::size_t triangles = mesh_.triangles.size();
    return triangles % 12 == 0 ? rootOf(triangles / 12) : 0;
  }

  [[nodiscard]] std::optional<v1::MeshSource> box() const {
    const auto side = [this](int axis) { return shortest(2.0 * high_[axis], high_[axis], half); };
    const BoxSource recipe{Vec3(side(0), side(1), side(2)), gridSegments()};
    const bool hasCorner = std::ranges::find(mesh_.vertices, high_) != mesh_.vertices.end();
    if (recipe.segments == 0 || !hasCorner || !isMadeBy(recipe)) return std::nullopt;
    v1::MeshSource source;
    v1::Vector3& size = *source.mutable_box()->mutable_size_m();
    size.set_x(recipe.size_m.x);
    size.set_y(recipe.size_m.y);
    size.set_z(recipe.size_m.z);
    source.mutable_box()->set_segments(recipe.segments);
    return source;
  }

  [[nodiscard]] std::optional<v1::MeshSource> sphere() const {
    const std::uint32_t n = gridSegments();
    if (n == 0 || high_.x != high_.y || high_.y != high_.z) return std::nullopt;
    const double off = n % 2 == 0 ? 0 : 1.0 / n, square = off * off;  // of the vertex nearest to the middle of a face
    const double highest = std::sqrt(1 - square / 2 - square / 2 + square * square / 3);
    const double radius_m = shortest(high_.x / highest, high_.x, [&](double r) { return r * highest; });
    const SphereSource recipe{radius_m, n};
    if (!isMadeBy(recipe)) return std::nullopt;
    v1::MeshSource source;
    source.mutable_sphere()->set_radius_m(recipe.radius_m);
    source.mutable_sphere()->set_segments(recipe.segments);
    return source;
  }

  [[nodiscard]] std::optional<v1::MeshSource> cylinder() const {
    const CylinderSource recipe{shortest(high_.x, high_.x, same), shortest(2.0 * high_.z, high_.z, half),
                                static_cast<std::uint32_t>(mesh_.triangles.size() / 4)};
    if (mesh_.vertices.size() != 2 * std::size_t{recipe.segments} + 2 || !isMadeBy(recipe)) return std::nullopt;
    v1::MeshSource source;
    source.mutable_cylinder()->set_radius_m(recipe.radius_m);
    source.mutable_cylinder()->set_height_m(recipe.height_m);
    source.mutable_cylinder()->set_segments(recipe.segments);
    return source;
  }

  [[nodiscard]] std::optional<v1::MeshSource> torus() const {
    const auto isOnFirstRing = [](const Vec3f v) { return v.y == 0 && v.x > 0; };
    const auto minorSegments = static_cast<std::uint32_t>(std::ranges::count_if(mesh_.vertices, isOnFirstRing));
    if (minorSegments < 3 || mesh_.vertices.size() % minorSegments != 0) return std::nullopt;
    // The highest vertex of a ring, where it has none right above its middle.
    double highest = 0;
    for (std::uint32_t j = 0; j < minorSegments; ++j) {
      highest = std::max(highest, std::sin(2 * M_PI * j / minorSegments));
    }
    const double minorRadius_m = shortest(high_.z / highest, high_.z, [&](double r) { return r * highest; });
    const double majorRadius_m =
        shortest(high_.x - minorRadius_m, high_.x, [&](double r) { return r + minorRadius_m; });
    const TorusSource recipe{majorRadius_m, minorRadius_m,
                             static_cast<std::uint32_t>(mesh_.vertices.size() / minorSegments), minorSegments};
    if (!isMadeBy(recipe)) return std::nullopt;
    v1::MeshSource source;
    source.mutable_torus()->set_major_radius_m(recipe.majorRadius_m);
    source.mutable_torus()->set_minor_radius_m(recipe.minorRadius_m);
    source.mutable_torus()->set_major_segments(recipe.majorSegments);
    source.mutable_torus()->set_minor_segments(recipe.minorSegments);
    return source;
  }
};

}  // namespace

std::optional<v1::MeshSource> generatorOf(const TriMesh& mesh) { return Recogniser(mesh).recognised(); }

}  // namespace haptics
