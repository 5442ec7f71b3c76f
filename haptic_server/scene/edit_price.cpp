#include "haptic_server/scene/edit_price.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <sstream>
#include <variant>
#include <vector>

#include "common/surface/makers/grown_reaction_diffusion.h"
#include "common/surface/point_field.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/geometry/long_triangles.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/engine/surface/surface_detail.h"
#include "haptic_server/engine/tool/tool_shell.h"
#include "haptic_server/simplification/probe_strokes.h"
#include "haptic_server/simplification/simplify.h"

namespace haptics {
namespace {

using std::numbers::pi;

struct LongestSide {
  double operator()(const BoxSource& s) const noexcept { return std::max({s.size_m.x, s.size_m.y, s.size_m.z}); }
  double operator()(const SphereSource& s) const noexcept { return 2 * s.radius_m; }
  double operator()(const CylinderSource& s) const noexcept { return std::max(2 * s.radius_m, s.height_m); }
  double operator()(const TorusSource& s) const noexcept { return 2 * (s.majorRadius_m + s.minorRadius_m); }
};

struct Area {
  double operator()(const BoxSource& s) const noexcept {
    return 2 * (s.size_m.x * s.size_m.y + s.size_m.y * s.size_m.z + s.size_m.z * s.size_m.x);
  }
  double operator()(const SphereSource& s) const noexcept { return 4 * pi * s.radius_m * s.radius_m; }
  double operator()(const CylinderSource& s) const noexcept { return 2 * pi * s.radius_m * (s.radius_m + s.height_m); }
  double operator()(const TorusSource& s) const noexcept { return 4 * pi * pi * s.majorRadius_m * s.minorRadius_m; }
};

double squared(double number) noexcept { return number * number; }

/// While cells are sought that are fine enough.
constexpr double kMemoryOfLong_bytes = 20 * kMaxListedOfAll;

/// To find the cells that long triangles pass through, and what passes through what in each (long_triangles.h).
double timeOfLong_s(double triangles) noexcept {
  constexpr double kSearch_s = 0.5;  // for a grid
  if (triangles < double(kFewLong)) return 0;
  const double listed = std::min(kMaxListed * triangles, kMaxListedOfAll);
  return std::min(2e-4 * triangles, kSearch_s) + 6e-7 * listed;
}

/// False: it is one-to-one, since its Jacobian is nowhere farther than 1 from the identity, in a box, which is convex. The
/// derivatives are means of the differences between neighbouring control points.
bool mayFold(const Lattice& lattice) noexcept {
  if (!glm::all(glm::greaterThan(lattice.size_m, Vec3(0)))) return true;  // it will be that of the mesh
  double farthest2 = 0;
  for (std::size_t axis = 0, stride = 1; axis < lattice.points.size(); stride *= lattice.points[axis++]) {
    const auto d = static_cast<int>(axis);
    const std::size_t along = lattice.points[axis];
    double most2 = 0;
    for (std::size_t i = 0; i + stride < lattice.control_m.size(); ++i) {
      if (i / stride % along == along - 1) continue;
      Vec3 difference = Vec3(lattice.control_m[i + stride]) - Vec3(lattice.control_m[i]);
      difference *= static_cast<double>(along - 1) / lattice.size_m[d];
      difference[d] -= 1;
      most2 = std::max(most2, glm::dot(difference, difference));
    }
    farthest2 += most2;
  }
  return !(farthest2 < 1);
}

/// Whether many triangles may become as long beside the whole as longTriangles() looks for: the lattice stretches a part of
/// the mesh's box by that much more than the rest. By samples, for a mesh whose triangles are of one size.
bool mayBecomeLong(const MeshNumbers& mesh, Lattice lattice) {
  constexpr int kSide = 5, kAll = kSide * kSide * kSide;
  constexpr double kEdges = 4;  // an edge is this much of the side, for one triangle
  if (mesh.longTriangles > 0 || !(mesh.longest_m > 0)) return true;
  const Vec3 low = mesh.centre_m - Vec3(mesh.longest_m / 2);
  const double step_m = mesh.longest_m / (kSide - 1);
  if (!glm::all(glm::greaterThan(lattice.size_m, Vec3(0)))) {  // it will be that of the mesh
    lattice.low_m = low;
    lattice.size_m = Vec3(mesh.longest_m);
  }
  std::vector<Vec3f> samples;
  for (int i = 0; i < kAll; ++i)
    samples.emplace_back(low + step_m * Vec3(i % kSide, i / kSide % kSide, i / kSide / kSide));
  samples = shapedBy(lattice, samples);
  Vec3f lowest = samples[0], highest = samples[0];
  float farthest_m = 0;
  for (int i = 0; i < kAll; ++i) {
    const auto at = static_cast<std::size_t>(i);
    lowest = glm::min(lowest, samples[at]);
    highest = glm::max(highest, samples[at]);
    for (int stride = 1; stride < kAll; stride *= kSide) {
      if (i / stride % kSide == kSide - 1) continue;
      farthest_m = std::max(farthest_m, glm::distance(samples[at], samples[at + static_cast<std::size_t>(stride)]));
    }
  }
  const Vec3f sides = highest - lowest;
  const double stretch = static_cast<double>(farthest_m) / step_m;
  return !(kEdges * mesh.longest_m / std::sqrt(mesh.triangles) * stretch <
           kLongShare * static_cast<double>(std::max({sides.x, sides.y, sides.z})));
}

/// To ask a field for one value, seconds.
double timeOfValue_s(const FieldFamily& family) noexcept {
  struct Ask {
    double operator()(const FourierFamily& fourier) const { return 3e-8 * static_cast<double>(fourier.terms.size()); }
    double operator()(const NoiseFamily& noise) const { return 1e-7 * noise.octaves; }
    double operator()(const CellularFamily&) const { return 1e-6; }
    double operator()(const GrainFamily&) const { return 2e-7; }
    double operator()(const MappedFamily&) const { return 2e-7; }
    double operator()(const GrownFamily&) const { return 1.5e-6; }
    double operator()(const LayeredFamily& layered) const {
      double sum_s = 0;
      for (const FieldLayer& layer : layered.layers) sum_s += timeOfValue_s(layer.family);
      return sum_s;
    }
  };
  return std::visit(Ask{}, static_cast<const std::variant<FourierFamily, NoiseFamily, CellularFamily, GrainFamily,
                                                          MappedFamily, LayeredFamily, GrownFamily>&>(family));
}

}  // namespace

Price& Price::operator+=(const Price& next) noexcept {
  time_s += next.time_s;
  kept_bytes += next.kept_bytes;
  working_bytes = std::max(working_bytes, next.working_bytes);
  return *this;
}

Result<void> checkPrice(const Price& price) {
  if (price.time_s <= kMaxTime_s && price.memory_bytes() <= kMaxMemory_bytes) return {};
  std::ostringstream text;
  text.precision(3);
  text << "take up to " << price.time_s << " s of a processor and " << price.memory_bytes() / 1e9
       << " GB together; one edit may take " << kMaxTime_s << " s and " << kMaxMemory_bytes / 1e9
       << " GB: give less detail, or send them in several";
  return refused("operations", text.str());
}

MeshNumbers numbersOf(const MeshAsset& mesh) {
  const Vec3 size = mesh.surface ? mesh.surface->high() - mesh.surface->low() : Vec3(0);
  return {.triangles = static_cast<double>(mesh.mesh->triangles.size()),
          .vertices = static_cast<double>(mesh.mesh->vertices.size()),
          .longest_m = std::max({size.x, size.y, size.z}),
          .centre_m = mesh.surface ? mesh.surface->low() + size / 2.0 : Vec3(0),
          .longTriangles = mesh.surface && mesh.surface->hierarchy().hasCells()
                               ? static_cast<double>(mesh.surface->triangleCount())
                               : 0,
          .closed = mesh.surface && mesh.surface->closed(),
          .closedAndPlain = mesh.surface && mesh.surface->closed() && !mesh.surface->anySelfIntersecting()};
}

MeshNumbers numbersOf(const MeshRecipe& recipe) noexcept {
  constexpr std::uint32_t kFewAround = 5;  // with more the boxes of its triangles overlap less than is looked at
  const double triangles = trianglesOf(recipe);
  const auto* torus = std::get_if<TorusSource>(&recipe);
  const bool areLong = torus && torus->majorSegments < kFewAround;
  return {.triangles = triangles,
          .vertices = triangles / 2 + 2,
          .longest_m = std::visit(LongestSide{}, recipe),
          .longTriangles = areLong ? triangles : 0};
}

double areaOf_m2(const MeshRecipe& recipe) noexcept { return std::visit(Area{}, recipe); }

Price priceOfMesh(const MeshNumbers& mesh) noexcept {
  return {.time_s = 2.8e-6 * mesh.triangles + timeOfLong_s(mesh.longTriangles),
          .kept_bytes = 118 * mesh.triangles + std::min(35 * mesh.triangles, 1.5e6),
          .working_bytes = 35 * mesh.triangles};
}

Price priceOfSimplifying(const MeshNumbers& mesh, double stiffness_N_per_m) noexcept {
  const double places = std::min(kMaxPlaces, placesOfStrokes(mesh.longest_m, stiffness_N_per_m));
  const double slower = mesh.closedAndPlain ? 1 : 4;
  return {.time_s = 0.02 + slower * (2e-5 * mesh.triangles + 1.5e-6 * places),
          .kept_bytes = 150 * mesh.triangles,
          .working_bytes = 300 * mesh.triangles + 200 * places};
}

Price priceOf(const FieldSource& source) noexcept {
  struct Made {
    Price operator()(const FileSource&) const { return {}; }
    Price operator()(const AssetSource&) const { return {}; }
    Price operator()(const ReactionDiffusionSource& source) const {
      const double samples = squared(source.resolution), cells = squared(source.cells);
      return {.time_s = 2e-7 * samples + 9e-4 * cells,
              .kept_bytes = 20 * samples,
              .working_bytes = 20 * samples + 4096 * cells};
    }
    Price operator()(const SpotNoiseSource& source) const {
      const double samples = squared(source.resolution);
      return {.time_s = 3.5e-7 * samples, .kept_bytes = 20 * samples, .working_bytes = 20 * samples};
    }
  };
  return std::visit(Made{}, source);
}

Price priceOfGrowing(const GrownReactionDiffusionSource& source, const MeshNumbers& mesh, double area_m2) noexcept {
  const double wanted = samplesToGrow(source, area_m2);
  const double samples = wanted <= static_cast<double>(PointField::kMaxSamples) ? wanted : 0;  // else it is refused
  return {.time_s = 3e-4 * samples + 5e-8 * mesh.triangles,
          .kept_bytes = 2000 * samples,
          .working_bytes = 2000 * samples + 40 * mesh.triangles};
}

Price priceOfShape(const MeshNumbers& mesh, const DeformationProperties& deformation) {
  Price price{.time_s = 1.2e-6 * mesh.triangles + timeOfLong_s(mesh.longTriangles),
              .kept_bytes = 150 * mesh.triangles,
              .working_bytes = 60 * mesh.triangles + (mesh.longTriangles < double(kFewLong) ? 0 : kMemoryOfLong_bytes)};
  if (!deformation.lattice) return price;
  const Lattice& lattice = *deformation.lattice;
  constexpr double kTimes = 2;  // for the shape, and to count what is left without an area
  price.time_s += kTimes * (1e-7 + 2.6e-9 * static_cast<double>(lattice.control_m.size())) * mesh.vertices;
  if (!mayFold(lattice)) return price;
  // All of its triangles may pass through each other.
  const double most = double(kMaxCrossingTests) + double(kMaxCrossingTestsEach) * mesh.triangles;
  const double tests = std::min(squared(mesh.triangles) / 2, most);
  price.time_s += 2e-8 * tests;
  if (!mesh.closed) return price;
  // It may be turned inside out, and then is built anew.
  price.time_s += 1.5e-6 * mesh.triangles + (mayBecomeLong(mesh, lattice) ? timeOfLong_s(mesh.triangles) : 0);
  return price;
}

Price priceOfBody(const MeshNumbers& mesh, const MotionProperties& motion) noexcept {
  const double triangles = mesh.triangles;
  Price price{.time_s = 1e-7 * triangles + 1e-7 * mesh.vertices, .kept_bytes = 1e6};
  if (!motion.inertia) {
    price += {.time_s = 3e-8 * triangles};
    // The sides of a mesh that may be open are sorted.
    if (!mesh.closedAndPlain)
      price += {.time_s = 3e-8 * triangles * (1.0 + std::ilogb(std::max(1.0, 3 * triangles))),
                .working_bytes = 50 * triangles};
  }
  if (!motion.planes.empty()) price += {.time_s = 2.5e-9 * kSupportDirections * mesh.vertices};
  if (motion.collision) price += {.time_s = 0.03 + 2.2e-6 * triangles, .working_bytes = 60 * triangles};
  return price;
}

Price priceOfTool(const MeshNumbers& mesh, double area_m2, double spacing_m) noexcept {
  const double wanted = dartsFor(area_m2, spacing_m);
  const double darts = wanted <= kMaxDarts ? wanted : 0;  // else it is refused
  Price price{.time_s = 0.03 + 1e-6 * darts + 1e-6 * mesh.triangles,
              .kept_bytes = 1e6,
              .working_bytes = 60 * darts + 60 * mesh.triangles};
  price.time_s += priceOfSharpPoints(mesh).time_s;
  return price;
}

Price priceOfShading(const MeshNumbers& mesh, std::size_t creases) noexcept {
  return {.time_s = (7e-7 + 3e-8 * static_cast<double>(std::bit_width(creases))) * mesh.triangles,
          .kept_bytes = 80 * mesh.triangles,
          .working_bytes = 60 * mesh.triangles};
}

Price priceOfLooking(const MeshNumbers& mesh) noexcept {
  return {.time_s = 1e-3 + 1e-7 * mesh.triangles, .kept_bytes = 1e5, .working_bytes = 20 * mesh.triangles};
}

Price priceOfSharpPoints(const MeshNumbers& mesh) noexcept {
  // Of a mesh that is not closed any line may be sharp, and long.
  if (!mesh.closedAndPlain) return {.time_s = std::min(1e-4 * mesh.triangles, 0.2 + 1e-5 * mesh.triangles)};
  return {.time_s = 2e-7 * mesh.triangles};
}

Price priceOf(const Texture& texture) noexcept {
  constexpr double kValues = 2.0 * 5 * TextureDetail::kSamples;
  return {.time_s = kValues * timeOfValue_s(texture.family), .kept_bytes = 8e6};
}

Price priceOf(const std::vector<Effect>& effects) noexcept {
  double models = 0;
  for (const Effect& effect : effects)
    models += static_cast<double>(effect.speeds_m_per_s.size() * effect.forces_N.size());
  return {.time_s = 4.5e-3 * models, .kept_bytes = 1e3 * models, .working_bytes = models > 0 ? 1e5 : 0};
}

Price priceOfDeciding(std::size_t operations, std::size_t objects) noexcept {
  const auto n = static_cast<double>(operations), all = static_cast<double>(objects);
  return {.time_s = 0.1 + 5e-5 * n + 1e-7 * n * all + 1e-5 * all, .kept_bytes = 64e6 + 1e4 * n};
}

}  // namespace haptics
