#include "graphics_client/surface/displayed_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/deform/triangle_map.h"
#include "common/surface/texture_pits.h"
#include "graphics_client/surface/mesh_normals.h"
#include "graphics_client/surface/refined_mesh.h"

namespace haptics {
namespace {

/// Fewer show another wave than is felt; more cost frames.
constexpr double kEdgesPerWave = 4;
/// Samples along each side of the square whose mean is drawn where the triangles are too coarse.
constexpr double kMaxSamplesPerSide = 5;
/// At a sharp crease the raised sides would meet far away: not farther than this many heights.
constexpr double kLongestMitre = 3;

/// A field as triangles of some size can carry it: with longer edges than a quarter of its wavelength, the mean over a
/// square of that side in the tangent plane.
class CarriedField {
 public:
  CarriedField(const ScalarField& field, double edge_m)
      : field_(field),
        side_m_(edge_m),
        samples_(static_cast<int>(std::clamp(
            std::ceil(kEdgesPerWave * edge_m / field.shortestWavelength_m() - kTolerance), 1.0, kMaxSamplesPerSide))) {}

  [[nodiscard]] bool filtered() const { return samples_ > 1; }

  [[nodiscard]] FieldSample at(Vec3 place, Vec3 normal) const {
    if (!filtered()) return field_.at(place);
    const Vec3 along = glm::normalize(glm::cross(normal, std::abs(normal.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
    const Vec3 across = glm::cross(normal, along);
    FieldSample mean;
    for (int i = 0; i < samples_; ++i) {
      for (int j = 0; j < samples_; ++j) {
        const FieldSample sample = field_.at(place + along * offset_m(i) + across * offset_m(j));
        mean.value += sample.value;
        mean.gradient += sample.gradient;
      }
    }
    const double count = samples_ * samples_;
    return {mean.value / count, mean.gradient / count};
  }

 private:
  static constexpr double kTolerance = 1e-6;

  [[nodiscard]] double offset_m(int i) const { return side_m_ * ((i + 0.5) / samples_ - 0.5); }

  const ScalarField& field_;
  double side_m_;
  int samples_;
};

/// For each place the way that a unit of height moves it: the normal, or at a crease the vector whose part along each of
/// the normals is 1 (in the mean, where there is none).
std::vector<Vec3> risingDirections(const RefinedMesh& mesh) {
  struct Sum {
    glm::dmat3 squares{0};
    Vec3 normals{0};
    int count = 0;
  };
  std::vector<Sum> sums(mesh.places.size());
  for (std::size_t v = 0; v < mesh.place.size(); ++v) {
    Sum& sum = sums[mesh.place[v]];
    sum.squares += glm::outerProduct(mesh.normals[v], mesh.normals[v]);
    sum.normals += mesh.normals[v];
    ++sum.count;
  }
  constexpr double kRegularisation = 1e-3;  // of directions of which no normal says anything
  std::vector<Vec3> directions;
  directions.reserve(sums.size());
  for (const Sum& sum : sums) {
    Vec3 direction = sum.normals;
    if (sum.count > 1) direction = glm::inverse(sum.squares + glm::dmat3(kRegularisation)) * direction;
    const double length = glm::length(direction);
    directions.push_back(length > kLongestMitre ? direction * (kLongestMitre / length) : direction);
  }
  return directions;
}

/// One normal for each place: of the first of its drawn vertices.
std::vector<Vec3> firstNormals(const RefinedMesh& mesh) {
  std::vector<Vec3> normals(mesh.places.size(), Vec3(0, 0, 1));
  for (std::size_t v = mesh.place.size(); v-- > 0;) normals[mesh.place[v]] = mesh.normals[v];
  return normals;
}

/// The mesh's places before it was deformed; none where it is not.
std::vector<Vec3> onMaterial(const RefinedMesh& mesh, std::span<const Vec3f> material) {
  std::vector<Vec3> places(material.begin(), material.end());
  if (material.empty()) return places;
  for (const auto& [a, b] : mesh.parents) places.push_back((places[a] + places[b]) / 2.0);
  return places;
}

/// As the triangles around a place have it, in the mean.
void deformGradients(const RefinedMesh& mesh, const std::vector<Vec3>& material, std::vector<FieldSample>& samples) {
  std::vector<Vec3> sums(samples.size(), Vec3(0));
  std::vector<int> counts(samples.size(), 0);
  for (const TriangleIndices& triangle : mesh.triangles) {
    TriangleMap::Corners now, before;
    for (std::size_t k = 0; k < 3; ++k) {
      now[k] = mesh.places[mesh.place[triangle[k]]];
      before[k] = material[mesh.place[triangle[k]]];
    }
    const TriangleMap map(now, before);
    for (const std::uint32_t v : triangle) {
      sums[mesh.place[v]] += map.gradient(samples[mesh.place[v]].gradient);
      ++counts[mesh.place[v]];
    }
  }
  for (std::size_t p = 0; p < samples.size(); ++p) samples[p].gradient = sums[p] / std::max(1.0, double(counts[p]));
}

std::vector<FieldSample> sampled(const CarriedField& field, const RefinedMesh& mesh, std::span<const Vec3f> material) {
  const std::vector<Vec3> normals = firstNormals(mesh);
  const std::vector<Vec3> before = onMaterial(mesh, material);
  const std::vector<Vec3>& places = before.empty() ? mesh.places : before;
  std::vector<FieldSample> samples(places.size());
  for (std::size_t p = 0; p < samples.size(); ++p) samples[p] = field.at(places[p], normals[p]);
  if (!before.empty()) deformGradients(mesh, before, samples);
  return samples;
}

void raise(DisplayedSurface& drawn, const RefinedMesh& mesh, const Texture& texture, const SurfaceFields& fields) {
  const ScalarField& field = *fields.texture;
  const CarriedField carried(field, mesh.longestEdge_m);
  drawn.filtered |= carried.filtered();
  const std::vector<FieldSample> samples = sampled(carried, mesh, fields.material);
  const std::vector<Vec3> directions = risingDirections(mesh);
  drawn.pitsAreFeltAsBumps = pitsAreFeltAsBumps(texture, field);
  const double zero = texture.literal ? 0 : field.lowest();
  const double range = field.highest() - field.lowest();
  drawn.heights.reserve(mesh.place.size());
  for (std::size_t v = 0; v < mesh.place.size(); ++v) {
    const std::uint32_t p = mesh.place[v];
    const Vec3 gradient = texture.amplitude_m * samples[p].gradient, normal = mesh.normals[v];
    const Vec3 rise = directions[p] * (texture.amplitude_m * (samples[p].value - zero));
    drawn.rises.emplace_back(rise);
    drawn.points[v] = mesh.places[p] + rise;
    drawn.normals[v] = glm::normalize(normal - gradient + glm::dot(gradient, normal) * normal);
    drawn.heights.push_back(static_cast<float>(range > 0 ? (samples[p].value - field.lowest()) / range : 0));
  }
}

std::vector<float> frictionOver(const RefinedMesh& mesh, const Friction& friction, const SurfaceFields& fields,
                                bool& filtered) {
  std::vector<double> factors(mesh.places.size());
  if (fields.friction) {
    const CarriedField carried(*fields.friction, mesh.longestEdge_m);
    filtered |= carried.filtered();
    const std::vector<FieldSample> samples = sampled(carried, mesh, fields.material);
    std::ranges::transform(samples, factors.begin(), [&](const FieldSample& sample) {
      return std::max(0.0, 1 + friction.variation * sample.value);
    });
  } else {
    const std::vector<float>& scale = *fields.frictionScale;
    std::ranges::copy(scale, factors.begin());
    for (std::size_t i = 0; i < mesh.parents.size(); ++i) {
      const auto [a, b] = mesh.parents[i];
      factors[scale.size() + i] = (factors[a] + factors[b]) / 2;
    }
  }
  std::vector<float> over;
  over.reserve(mesh.place.size());
  for (const std::uint32_t p : mesh.place) over.push_back(static_cast<float>(friction.mu_static * factors[p]));
  return over;
}

std::vector<std::array<std::uint32_t, 2>> rimsOf(const RefinedMesh& mesh) {
  std::vector<std::array<std::uint32_t, 2>> rims;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if ((mesh.rims[t] >> k & 1) == 0) continue;
      const auto [a, b] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      rims.push_back({a, b});
    }
  }
  std::ranges::sort(rims);
  rims.erase(std::unique(rims.begin(), rims.end()), rims.end());
  return rims;
}

/// As the mesh is, without a field.
DisplayedSurface plainSurface(const TriMesh& mesh, const std::optional<Shading>& shading) {
  if (!shading) {
    return {.points = mesh.vertices, .triangles = mesh.triangles, .closed = isClosed(mesh)};
  }
  ShadedMesh shaded = shadeMesh(mesh, shading->crease_rad, shading->creases);
  DisplayedSurface drawn{
      .normals = std::move(shaded.normals), .triangles = std::move(shaded.triangles), .closed = isClosed(mesh)};
  drawn.points.reserve(shaded.source.size());
  for (const std::uint32_t v : shaded.source) drawn.points.push_back(mesh.vertices[v]);
  return drawn;
}

}  // namespace

DisplayedSurface displaySurface(const TriMesh& mesh, const SurfaceProperties& properties, const SurfaceFields& fields,
                                std::size_t maxTriangles) {
  const bool frictionVaries = properties.friction && (fields.friction || fields.frictionScale);
  if (!fields.texture && !frictionVaries) return plainSurface(mesh, properties.shading);
  double finest_m = std::numeric_limits<double>::infinity();
  for (const auto& field : {fields.texture, fields.friction}) {
    if (field) finest_m = std::min(finest_m, field->shortestWavelength_m());
  }
  const ShadedMesh shaded = properties.shading
                                ? shadeMesh(mesh, properties.shading->crease_rad, properties.shading->creases)
                                : shadeMesh(mesh, kSamePlane_rad);
  RefinedMesh refined = refine(mesh, shaded, finest_m / kEdgesPerWave, maxTriangles);
  DisplayedSurface drawn{.normals = {refined.normals.begin(), refined.normals.end()},
                         .triangles = refined.triangles,
                         .closed = isClosed(mesh),
                         .longestEdge_m = refined.longestEdge_m};
  if (std::isfinite(finest_m)) drawn.finestDetail_m = finest_m;
  drawn.points.reserve(refined.place.size());
  for (const std::uint32_t p : refined.place) drawn.points.emplace_back(refined.places[p]);
  if (refined.triangles.size() > mesh.triangles.size()) drawn.rims = rimsOf(refined);
  if (fields.texture) raise(drawn, refined, *properties.texture, fields);
  if (frictionVaries) drawn.friction = frictionOver(refined, *properties.friction, fields, drawn.filtered);
  return drawn;
}

}  // namespace haptics
