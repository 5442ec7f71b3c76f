#include "haptic_server/scene/surface_warnings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <utility>

#include "common/surface/texture_pits.h"
#include "haptic_server/engine/motion/coupling.h"
#include "haptic_server/engine/surface/surface_detail.h"
#include "haptic_server/engine/tool/tool_shell.h"
#include "haptic_server/scene/derived_parts.h"

namespace haptics {
namespace {

/// Fewer samples than this a wave show another one (Shannon).
constexpr double kSamplesPerWave = 2;

/// The parts one after the other, numbers with so many digits.
template <class... Parts>
std::string written(int digits, const Parts&... parts) {
  std::ostringstream text;
  text.precision(digits);
  (text << ... << parts);
  return text.str();
}

SurfaceFactor factorOf(const SurfaceMap& map, const std::shared_ptr<const ScalarField>& field,
                       const std::shared_ptr<const VertexValuesAsset>& scale) {
  FactorSource source{field, nullptr};
  if (scale) source.scale = scale->values;
  return {map.variation, std::move(source), kMinStiffnessFactor};
}

/// Highest factor of the stiffness over the surface; 1 where it is the same everywhere.
double highestFactor(const ObjectRecord& record, const ObjectAssets& assets) {
  const auto& map = record.material.surface.stiffnessOver;
  return map ? factorOf(*map, assets.stiffnessField, assets.stiffnessScale).highest() : 1;
}

/// Empty when what a map pushes sideways is felt whole, up to a press of 1 N.
std::string pushWarning(const std::string& property, const SurfaceFactor& factor, double spring_N_per_m,
                        const DeviceLimits& device) {
  constexpr double kPress_N = 1;
  const double lateral_N_per_m = factor.lateralStiffness_N_per_m(spring_N_per_m, kPress_N / spring_N_per_m);
  if (lateral_N_per_m <= device.stableLateral_N_per_m) return {};
  return written(4, "warning: under a press of 1 N ", property, " pushes sideways with ",
                 100 * device.stableLateral_N_per_m / lateral_N_per_m,
                 " % of what keeps a closed loop from giving energy: with all of it, it would be a spring of up to ",
                 lateral_N_per_m, " N/m, and the device is locally stable up to ", device.stableLateral_N_per_m,
                 " N/m; less variation or a longer wave keeps it");
}

/// Stiffness that is rendered at the stiffest point.
double stiffestPlace_N_per_m(const ObjectRecord& record, const ObjectAssets& assets, const DeviceLimits& device) {
  return std::min(record.material.stiffness_N_per_m * highestFactor(record, assets), device.stiffest_N_per_m);
}

/// Empty when it is felt as it was asked for, up to a press of 1 N.
std::string bumpWarning(const TextureDetail& detail, double stiffness_N_per_m, const DeviceLimits& device) {
  constexpr double kPress_N = 1;
  const double depth_m = kPress_N / stiffness_N_per_m;
  const double part = detail.slopeShareFor(depth_m, stiffness_N_per_m, device.stableLateral_N_per_m);
  if (!(part < 1)) return {};
  return written(4, "warning: under a press of 1 N the texture's slopes are felt as ", 100 * part,
                 " % of themselves: sideways it would be a spring of ", device.stableLateral_N_per_m / part,
                 " N/m, and the device is locally stable up to ", device.stableLateral_N_per_m,
                 " N/m; a lower amplitude, a longer wave or a softer surface keeps them");
}

/// Empty when it is felt as it was asked for.
std::string clampWarning(const ObjectRecord& record, const ObjectAssets& assets, const DeviceLimits& device) {
  if (std::isinf(device.stableLateral_N_per_m)) return {};  // to sample the texture takes milliseconds
  const Texture& texture = *record.material.surface.texture;
  const double k = stiffestPlace_N_per_m(record, assets, device);
  const TextureDetail detail(*assets.mesh->surface, texture, assets.textureField);
  if (texture.law == Texture::Law::kBump) return bumpWarning(detail, k, device);
  const double gain = detail.gainFor(k, device.stableLateral_N_per_m);
  if (gain >= texture.gain_K) return {};
  return written(4, "warning: texture's gain_K is felt as ", gain, " instead of ", texture.gain_K,
                 ": sideways it would be a spring of ", k * texture.gain_K * detail.steepness(),
                 " N/m, and the device is locally stable up to ", device.stableLateral_N_per_m,
                 " N/m; a lower amplitude, a longer wave or a softer surface keeps it");
}

/// Empty when a texture below 0 is felt as a pit, or none is below 0.
std::string literalWarning(const Texture& texture, const ScalarField& field) {
  if (!pitsAreFeltAsBumps(texture, field)) return {};
  return "warning: the texture is literal and goes below 0: there it is drawn as a pit and felt as a bump, for Eq. "
         "(4a) as printed pulls uphill where h < 0; TEXTURE_LAW_BUMP is felt as a pit, and without literal nothing is "
         "below 0";
}

/// Empty when it is felt as it was asked for.
std::string stiffnessWarning(const ObjectRecord& record, const ObjectAssets& assets, const DeviceLimits& device) {
  const double asked = record.material.stiffness_N_per_m * highestFactor(record, assets);
  if (asked <= device.stiffest_N_per_m) return {};
  return written(
      6, "warning: stiffness_N_per_m is felt as ", std::floor(device.stiffest_N_per_m), " instead of ", asked,
      record.material.surface.stiffnessOver ? ", its most by stiffness_over, and likewise wherever it is beyond" : "",
      ": the device comes to rest on walls of up to ", std::floor(2 * device.stiffest_N_per_m),
      " N/m by simulation, and half of that is what a surface may have; a higher rate or less delay allows more");
}

/// Empty when one step of the encoder changes the force by less than kFeltStep_N. Friction and observer keep the loop stable
/// above it, but no force between two steps is known: where a hand strokes the surface, the depth goes through them.
std::string stepWarning(const ObjectRecord& record, const ObjectAssets& assets, const DeviceLimits& device) {
  constexpr double kFeltStep_N = 0.25;
  const double step_N = stiffestPlace_N_per_m(record, assets, device) * device.encoderStep_m;
  if (step_N <= kFeltStep_N) return {};
  return written(4, "warning: stiffness_N_per_m makes ", step_N, " N of one step of the device's encoder (",
                 millimetres(device.encoderStep_m), "), which a hand that strokes the surface feels as a buzz; up to ",
                 std::floor(kFeltStep_N / device.encoderStep_m), " N/m it is ", kFeltStep_N, " N at most");
}

/// Empty when it is felt as it was asked for.
std::string dampingWarning(const ObjectRecord& record, const ObjectAssets& assets, const DeviceLimits& device) {
  const double felt_N_per_m = stiffestPlace_N_per_m(record, assets, device);
  const bool varies = record.material.surface.stiffnessOver.has_value();
  const double highest = varies ? felt_N_per_m / record.material.stiffness_N_per_m : 1;
  const double asked = highest * record.material.damping_Ns_per_m;
  if (asked <= device.maxDamping_Ns_per_m) return {};
  return written(
      4, "warning: damping_Ns_per_m is felt as ", device.maxDamping_Ns_per_m, " instead of ", asked,
      varies ? ", its most by stiffness_over, and less by the same ratio elsewhere" : "",
      ": the device comes to rest on walls with up to ", 2 * device.maxDamping_Ns_per_m,
      " Ns/m by simulation, and half of that is what a surface may have; a higher rate or less delay allows more");
}

/// Empty when it is felt as it was asked for, or there is none.
std::string tapWarning(const SurfaceScalars<double>& scalars) {
  if (scalars.tap_Ns_per_m == 0) return {};
  if (scalars.tap_Hz == 0) return "warning: tap_Ns_per_m is not felt: tap_Hz is 0 or missing";
  if (scalars.tap_decay_per_s >= kSlowestTap_per_s) return {};
  return written(4, "warning: tap_decay_per_s is felt as ", kSlowestTap_per_s, " instead of ", scalars.tap_decay_per_s,
                 ": a tap is over after 0.1 s");
}

}  // namespace

double meanEdge_m(const TriMesh& mesh) {
  constexpr std::size_t kMeasuredTriangles = 10'000;  // enough for a mean
  const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / kMeasuredTriangles);
  double sum_m = 0;
  std::size_t edges = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
    const TriangleIndices& corner = mesh.triangles[t];
    for (std::size_t k = 0; k < corner.size(); ++k, ++edges) {
      sum_m += glm::distance(Vec3(mesh.vertices[corner[k]]), Vec3(mesh.vertices[corner[(k + 1) % corner.size()]]));
    }
  }
  return sum_m / static_cast<double>(edges);
}

std::string millimetres(double length_m) {
  constexpr double kMillimetresPerMetre = 1000;
  return written(3, length_m * kMillimetresPerMetre, " mm");
}

std::vector<std::string> surfaceWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                         const DeviceLimits& device) {
  std::vector<std::string> warnings;
  const auto add = [&](std::string warning) {
    if (!warning.empty()) warnings.push_back(std::move(warning));
  };
  add(stiffnessWarning(record, assets, device));
  add(stepWarning(record, assets, device));
  add(dampingWarning(record, assets, device));
  add(tapWarning(record.material.surface.scalars));
  const auto look = [&](const char* property, const ScalarField* field) {
    if (!field) return;
    const double finest_m = field->shortestWavelength_m();
    const std::string warning = "warning: " + std::string(property) + "'s finest detail, " + millimetres(finest_m);
    if (finest_m < kSamplesPerWave * device.encoderStep_m) {
      warnings.push_back(warning + ", is finer than two steps of the device's encoder (" +
                         millimetres(device.encoderStep_m) + " each): it will feel like another one, and rough");
    }
    const double edge_m = meanEdge_m(*assets.mesh->mesh);
    if (finest_m < kSamplesPerWave * edge_m) {
      warnings.push_back(warning + ", is finer than two edges of the mesh (" + millimetres(edge_m) +
                         " each on average): it is felt as given; a picture may not show it");
    }
  };
  const SurfaceProperties& surface = record.material.surface;
  if (surface.texture) {
    look("texture", assets.textureField.get());
    add(clampWarning(record, assets, device));
    add(literalWarning(*surface.texture, *assets.textureField));
  }
  if (surface.friction) {
    look("friction", assets.frictionField.get());
    look("dynamic friction", assets.dynamicFrictionField.get());
  }
  const auto lookAtMap = [&](const char* property, const std::optional<SurfaceMap>& map,
                             const std::shared_ptr<const ScalarField>& field,
                             const std::shared_ptr<const VertexValuesAsset>& scale, double spring_N_per_m) {
    if (!map) return;
    look(property, field.get());
    add(pushWarning(property, factorOf(*map, field, scale), spring_N_per_m, device));
  };
  lookAtMap("stiffness_over", surface.stiffnessOver, assets.stiffnessField, assets.stiffnessScale,
            record.material.stiffness_N_per_m);
  if (const auto& softness = record.deformation.softness) {
    lookAtMap("softness_over", surface.softnessOver, assets.softnessField, assets.softnessScale,
              softness->stiffness_N_per_m);
  }
  return warnings;
}

namespace {

/// Of a tick at 1 kHz, which has them followed on a million triangles in 150 us at the 99th percentile (tool/README.md).
constexpr double kManyToolPoints = 4'000;
constexpr double kTickOfPoint_us = 0.037;

std::vector<std::string> toolWarnings(const Tool& tool, const ToolProperties& asked, const DeviceLimits& device) {
  std::vector<std::string> warnings;
  const ToolShell& shell = tool.shell;
  const auto points = static_cast<double>(shell.points.size()), spaced = static_cast<double>(shell.spaced);
  const double many = std::min(1.0, device.period_s / 1e-3) * kManyToolPoints;
  if (points > many) {
    const bool manyVertices = points - spaced > many / 2;
    warnings.push_back(written(
        4, "warning: the tool touches with ", points, " points; where they meet fine meshes they take some ",
        points * kTickOfPoint_us, " us of a tick of ", 1e6 * device.period_s,
        " us, which may be more than its allowance: the tool lags behind the hand there; ",
        manyVertices ? std::string("many of them are vertices, and a mesh of fewer triangles has fewer")
                     : written(4, "a spacing_m of ", asked.spacing_m * std::sqrt(spaced / (many - points + spaced)),
                               " has about ", many)));
  }
  if (shell.nearVertex_m > kNearVertex_m) {
    warnings.push_back(
        "warning: the tool's mesh has more vertices than are followed: one is up to " +
        millimetres(shell.nearVertex_m) + " from the nearest of the " + std::to_string(shell.points.size()) +
        " points, and may be so deep in what the tool touches; of a mesh of fewer triangles fewer are left out");
  }
  if (asked.torsion_Nm_per_rad > device.stiffestTorsion_Nm_per_rad) {
    warnings.push_back(
        written(4, "warning: torsion_Nm_per_rad is felt as ", device.stiffestTorsion_Nm_per_rad, " instead of ",
                asked.torsion_Nm_per_rad, ": by simulation the device comes to rest with up to ",
                2 * device.stiffestTorsion_Nm_per_rad,
                " Nm/rad, and half of that is what a tool may have; a higher rate or less delay allows more"));
  }
  if (asked.jaws && asked.jaws->grip_Nm_per_rad > device.stiffestGrip_Nm_per_rad) {
    warnings.push_back(written(4, "warning: grip_Nm_per_rad is felt as ", device.stiffestGrip_Nm_per_rad,
                               " instead of ", asked.jaws->grip_Nm_per_rad,
                               ", the most that the device's gripper bears"));
  }
  return warnings;
}

}  // namespace

std::vector<std::string> motionWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                        const DeviceLimits& device) {
  const auto body = bodyPartsOf(record, assets);
  if (!body || !*body) return {};
  if ((*body)->tool) return toolWarnings(*(*body)->tool, *record.motion->tool, device);
  if (!(*body)->body) return {};
  const double mass_kg = (*body)->apparentMass_kg;
  const double stiffness = std::min(record.material.stiffness_N_per_m, device.stiffest_N_per_m);
  const double damping = std::min(record.material.damping_Ns_per_m, device.maxDamping_Ns_per_m);
  const double share = stableStiffnessShare(mass_kg / device.hands, stiffness, damping, device.period_s);
  if (share >= 1) return {};
  return {written(4, "warning: stiffness and damping are felt as ", share * stiffness, " N/m and ", share * damping,
                  " N s/m instead of ", stiffness, " and ", damping,
                  ": pushed where it gives most, this body weighs no more than ", 1e3 * mass_kg, " g, and at ",
                  1 / device.period_s, " Hz it would be thrown about; from ", record.motion->mass_kg / share,
                  " kg on, or at a higher rate, it bears them")};
}

}  // namespace haptics
