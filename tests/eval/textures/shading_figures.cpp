#include "tests/eval/textures/shading_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/maths/perception.h"
#include "tests/eval/analytic_shapes.h"
#include "tests/eval/random.h"
#include "tests/eval/statistics.h"
#include "tests/eval/textures/texture_sample.h"

namespace haptics::eval {
namespace {

constexpr double kSpring = 1000;  // N/m
constexpr double kCrease_rad = 40 * std::numbers::pi / 180;

const AnalyticShape& shapeCalled(std::string_view name) {
  return *std::ranges::find(analyticShapes(), name, &AnalyticShape::name);
}

/// A shape's mesh, shaded or not, felt.
class FeltShading {
 public:
  FeltShading(const TriMesh& mesh, const std::optional<Shading>& shading, Random& random)
      : surface_(buildCollisionMesh(mesh.vertices, mesh.triangles)),
        specimen_(surface_, detailOf(shading), feel(random)) {}

  TextureSample& specimen() { return specimen_; }

 private:
  [[nodiscard]] std::shared_ptr<const SurfaceDetail> detailOf(const std::optional<Shading>& shading) const {
    SurfaceProperties properties;
    properties.shading = shading;
    return makeSurfaceDetail(*surface_, properties, {});
  }
  static Feel feel(Random& random) {
    Feel made;
    made.stiffness_N_per_m = kSpring;
    made.pose = {random.rotation(), random.direction() * 0.05};
    return made;
  }

  std::shared_ptr<const CollisionMesh> surface_;
  TextureSample specimen_;
};

struct Errors {
  Statistics position_mm;  ///< Of the surface as felt, HIP + F / k.
  Statistics direction_deg;
  double forceStep_N = 0;  ///< Largest |dF - dF of the exact shape| from tick to tick.
};

/// Pressed 2 mm deep and stroked at 0.1 m/s.
Errors stroke(TextureSample& specimen, const AnalyticShape& shape) {
  constexpr double kHipDepth_m = 2e-3;
  constexpr double kStep_m = 1e-4;
  Errors errors;
  specimen.place(shape.at(0, -kHipDepth_m).hip);
  for (double depth = -kHipDepth_m; depth < kHipDepth_m; depth += kStep_m) (void)specimen.tick(shape.at(0, depth).hip);
  Vec3 lastError_N(0);
  for (double way = 0; way <= kPath_m; way += kStep_m) {
    const Truth truth = shape.at(way, kHipDepth_m);
    const Vec3 exact_N = kSpring * (truth.ihip - truth.hip);
    const Vec3 felt_N = specimen.tick(truth.hip).force.contact;
    const Vec3 error_N = felt_N - exact_N;
    if (way > 10 * kStep_m) {
      errors.position_mm.add(glm::length(error_N) / kSpring * 1e3);
      errors.direction_deg.add(angle_deg(felt_N, exact_N));
      errors.forceStep_N = std::max(errors.forceStep_N, glm::distance(error_N, lastError_N));
    }
    lastError_N = error_N;
  }
  return errors;
}

Record strokeShape(std::string_view name, int triangles, bool shaded, Random& random) {
  const AnalyticShape& shape = shapeCalled(name);
  const TriMesh mesh = shape.mesh(triangles);
  FeltShading felt(mesh, shaded ? std::optional(Shading{kCrease_rad, {}}) : std::nullopt, random);
  Errors errors = stroke(felt.specimen(), shape);
  const bool fine = mesh.triangles.size() > 10'000;
  const double direction = errors.direction_deg.rms();
  const bool good =
      fine ? errors.position_mm.rms() <= 0.0045 && direction <= 0.05 && errors.forceStep_N <= 0.001 : direction <= 0.25;
  return {{"method", shaded ? "ours" : "ours_unshaded"},
          {"scene", "shading_" + std::string(name)},
          {"triangles", mesh.triangles.size()},
          {"depth_mm", 2},
          {"position_error_rms_mm", errors.position_mm.rms()},
          {"position_error_max_mm", errors.position_mm.max()},
          {"direction_error_rms_deg", direction},
          {"direction_error_max_deg", errors.direction_deg.max()},
          {"force_step_error_max_N", errors.forceStep_N},
          {"pass", !shaded || good}};
}

/// Pressed `depth_m` at a place of a flat side: the force's angle to its normal, degrees.
double tiltAt(TextureSample& specimen, Vec3 place, Vec3 normal) {
  constexpr double kHipDepth_m = 1e-3;
  specimen.place(place + normal * kHipDepth_m);
  specimen.lead(place - normal * kHipDepth_m, 50e-6);
  Touch touch;
  for (int i = 0; i < 100; ++i) touch = specimen.tick(place - normal * kHipDepth_m);
  return angle_deg(touch.force.contact, normal);
}

constexpr double kFromEdge_m = 0.5e-3;

/// Half a millimetre from the cylinder's end edge, on the end and on the side.
Record pressAtCylindersEdge(bool shaded, Random& random) {
  constexpr double kRadius_m = 0.03;
  constexpr double kHalf_m = 0.05;
  const TriMesh mesh = shapeCalled("cylinder").mesh(12288);
  FeltShading felt(mesh, shaded ? std::optional(Shading{kCrease_rad, {}}) : std::nullopt, random);
  double end_deg = 0;
  double side_deg = 0;
  for (int i = 0; i < 50; ++i) {
    const double turn = random.between(0, 2 * std::numbers::pi);
    const Vec3 outwards{std::cos(turn), std::sin(turn), 0};
    end_deg = std::max(end_deg,
                       tiltAt(felt.specimen(), outwards * (kRadius_m - kFromEdge_m) + Vec3(0, 0, kHalf_m), {0, 0, 1}));
    side_deg =
        std::max(side_deg, tiltAt(felt.specimen(), outwards * kRadius_m + Vec3(0, 0, kHalf_m - kFromEdge_m), outwards));
  }
  return {{"method", shaded ? "ours" : "ours_unshaded"},
          {"scene", "shading_crease_cylinder"},
          {"triangles", mesh.triangles.size()},
          {"from_edge_mm", kFromEdge_m * 1e3},
          {"end_direction_error_max_deg", end_deg},
          {"side_direction_error_max_deg", side_deg},
          {"pass", !shaded || (end_deg <= 1 && side_deg <= 1)}};
}

/// The lines of a cube's edges, as an object gives explicit creases.
std::vector<Crease> edgesOf(const TriMesh& cube, double half_m) {
  std::set<Crease> lines;
  const auto sides = [&](Vec3f v) {
    int count = 0;
    for (int axis = 0; axis < 3; ++axis) count += std::abs(std::abs(v[axis]) - half_m) < 1e-6 ? 1 : 0;
    return count;
  };
  for (const TriangleIndices& t : cube.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k];
      const std::uint32_t b = t[(k + 1) % 3];
      const Vec3f middle = (cube.vertices[a] + cube.vertices[b]) * 0.5F;
      if (sides(middle) >= 2) lines.insert({std::min(a, b), std::max(a, b)});
    }
  }
  return {lines.begin(), lines.end()};
}

/// A cube, its edges sharp by their angle or given one by one.
Record pressAtCubesEdge(bool given, Random& random) {
  constexpr double kHalf_m = 0.05;
  const TriMesh mesh = shapeCalled("cube").mesh(768);
  const Shading shading = given ? Shading{std::numbers::pi, edgesOf(mesh, kHalf_m)} : Shading{kCrease_rad, {}};
  FeltShading felt(mesh, shading, random);
  double most_deg = 0;
  for (int i = 0; i < 50; ++i) {
    const Vec3 place{random.sign() * (kHalf_m - kFromEdge_m), random.between(-0.04, 0.04), kHalf_m};
    most_deg = std::max(most_deg, tiltAt(felt.specimen(), place, {0, 0, 1}));
  }
  return {{"method", "ours"},
          {"scene", given ? "shading_crease_cube_given" : "shading_crease_cube"},
          {"triangles", mesh.triangles.size()},
          {"from_edge_mm", kFromEdge_m * 1e3},
          {"direction_error_max_deg", most_deg},
          {"pass", most_deg <= 1}};
}

}  // namespace

std::vector<Record> measureShading(std::uint64_t seed) {
  Random random(seed);
  std::vector<Record> records;
  for (const int triangles : {12 * 12 * 12, 12 * 74 * 74}) {
    for (const bool shaded : {false, true}) records.push_back(strokeShape("sphere", triangles, shaded, random));
  }
  for (const std::string_view name : {"torus", "cylinder"}) {
    for (const bool shaded : {false, true}) records.push_back(strokeShape(name, 12 * 74 * 74, shaded, random));
  }
  for (const bool shaded : {false, true}) records.push_back(pressAtCylindersEdge(shaded, random));
  for (const bool given : {false, true}) records.push_back(pressAtCubesEdge(given, random));
  return records;
}

}  // namespace haptics::eval
