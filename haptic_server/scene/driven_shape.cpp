#include "haptic_server/scene/driven_shape.h"

#include <cmath>
#include <utility>

#include "haptic_server/scene/fit_to_mesh.h"

namespace haptics {
namespace {

/// For a triangle, in a tick, on a usual processor.
constexpr double kMove_s = 1e-8;
constexpr double kShareOfTick = 0.2;

}  // namespace

std::uint64_t DrivenShape::first() const noexcept {
  return !samples.empty() && !samples.front()->lattice ? number + 2 - samples.size() : 0;
}

void DrivenShape::take(std::shared_ptr<const Sample> sample, bool isMore) {
  if (!isMore) samples.pop_back();
  samples.push_back(std::move(sample));
  if (isMore) ++number;
  if (samples.size() > ShapeSamples::kMax) samples.erase(samples.begin());
}

std::optional<std::string> whyNotReshaped(const ObjectRecord& object) {
  if (object.movesByItself()) return "moves by itself";
  if (object.motion && object.motion->collision) return "meets other bodies (motion.collision)";
  if (object.deformation.softness) return "yields (deformation.softness)";
  if (object.material.surface.shading) return "is rounded (material.shading)";
  return std::nullopt;
}

Result<DrivenShape::Sample> shapeSample(const ObjectRecord& object, const ObjectAssets& assets, Lattice lattice,
                                        bool latticeOfMesh) {
  DeformationProperties deformation{.softness = {}, .lattice = std::move(lattice)};
  if (auto unfit = fitToMesh(deformation, *assets.mesh->mesh, latticeOfMesh)) return tl::unexpected(*std::move(unfit));
  std::vector<Vec3f> vertices = shapedBy(*deformation.lattice, assets.mesh->mesh->vertices);
  if (assets.turnsOver(assets.shapeAtRest(object.deformation), vertices)) {
    return refused(
        "lattice",
        "turns the object inside out, which no motion does; without kinematic its faces are turned over too");
  }
  return DrivenShape::Sample{std::move(deformation.lattice),
                             std::make_shared<const std::vector<Vec3f>>(std::move(vertices))};
}

DrivenShape::Sample ownShape(const ObjectRecord& object, const ObjectAssets& assets) {
  return {std::nullopt, std::make_shared<const std::vector<Vec3f>>(assets.shapeAtRest(object.deformation))};
}

std::size_t mostDrivenTriangles(const DeviceLimits& device) noexcept {
  return static_cast<std::size_t>(std::floor(kShareOfTick * device.period_s / (kMove_s * device.hands)));
}

}  // namespace haptics
