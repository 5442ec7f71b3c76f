#include "haptic_server/net/shape_updates.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "common/wire/driven_shapes.h"

namespace haptics {
namespace {

/// Control points where the lattice moves nothing.
[[nodiscard]] std::vector<Vec3f> unmoved(const Lattice& lattice) {
  std::vector<Vec3f> control_m;
  const auto [nx, ny, nz] = lattice.points;
  for (std::uint32_t z = 0; z < nz; ++z) {
    for (std::uint32_t y = 0; y < ny; ++y) {
      for (std::uint32_t x = 0; x < nx; ++x)
        control_m.emplace_back(lattice.low_m + Vec3(x / (nx - 1.0), y / (ny - 1.0), z / (nz - 1.0)) * lattice.size_m);
    }
  }
  return control_m;
}

/// Vertices go on straight lines where the control points of one lattice do; of two that differ otherwise, the nearer one.
/// @param from  None: as if without a lattice.
[[nodiscard]] std::optional<Lattice> mixed(const std::optional<Lattice>& from, const std::optional<Lattice>& to,
                                           double part) {
  if (part == 0) return from;
  const bool isSame =
      to && (!from || (from->points == to->points && from->low_m == to->low_m && from->size_m == to->size_m));
  if (!isSame) return part < 0.5 ? from : to;
  Lattice between = *to;
  const std::vector<Vec3f> before = from ? from->control_m : unmoved(*to);
  for (std::size_t i = 0; i < before.size(); ++i)
    between.control_m[i] = Vec3f(glm::mix(Vec3(before[i]), Vec3(to->control_m[i]), part));
  return between;
}

}  // namespace

void ShapeUpdates::add(const ShapePlaces& places, const SceneService::DrivenShapes& shapes, std::uint64_t now_ns,
                       v1::Telemetry& sample) {
  std::erase_if(sent_, [&](const auto& entry) { return !shapes.contains(entry.first); });
  for (const ShapePlace& place : places.all()) {
    const auto driven = shapes.find(place.object);
    if (driven == shapes.end()) continue;
    Sent& sent = sent_[place.object];
    if (sent.at == place.sample && now_ns - sent.when_ns < kEvery_ns) continue;
    sent = {place.sample, now_ns};
    const auto& samples = driven->second.samples;
    const double newest = static_cast<double>(samples.size()) - 1;
    const double at = std::clamp(newest - (static_cast<double>(driven->second.number) - place.sample), 0.0, newest);
    const double from = std::min(std::floor(at), newest - 1);
    const auto i = static_cast<std::size_t>(from);
    v1::DrivenShape& shape = *sample.add_shape();
    shape.set_object(place.object);
    const std::optional<Lattice> between = mixed(samples[i]->lattice, samples[i + 1]->lattice, at - from);
    if (between) toWire(*between, *shape.mutable_lattice());
  }
}

}  // namespace haptics
