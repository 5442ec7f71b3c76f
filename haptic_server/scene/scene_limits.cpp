#include "haptic_server/scene/scene_limits.h"

#include <variant>

#include "common/wire/convert.h"

namespace haptics {

namespace {

std::size_t detailSizeOf(const FieldFamily& family) {
  constexpr std::size_t kTerm_bytes = 64, kLayer_bytes = 192;  // of a mapped family
  if (const auto* fourier = std::get_if<FourierFamily>(&family)) return kTerm_bytes * fourier->terms.size();
  const auto* layered = std::get_if<LayeredFamily>(&family);
  if (!layered) return 0;
  std::size_t bytes = kLayer_bytes * layered->layers.size();
  for (const FieldLayer& layer : layered->layers) bytes += detailSizeOf(layer.family);
  return bytes;
}

}  // namespace

std::size_t detailSizeOf(const ObjectRecord& record) {
  constexpr std::size_t kCrease_bytes = 16, kControlPoint_bytes = 12;
  const SurfaceProperties& surface = record.material.surface;
  std::size_t bytes = 0;
  if (record.deformation.lattice) bytes += kControlPoint_bytes * record.deformation.lattice->control_m.size();
  if (surface.shading) bytes += kCrease_bytes * surface.shading->creases.size();
  if (surface.texture) bytes += detailSizeOf(surface.texture->family);
  const auto add = [&bytes](const FactorMap& map) {
    if (const auto* field = std::get_if<FieldFamily>(&map)) bytes += detailSizeOf(*field);
  };
  if (surface.friction) {
    add(surface.friction->over);
    add(surface.friction->dynamicOver);
  }
  if (surface.stiffnessOver) add(surface.stiffnessOver->over);
  if (surface.softnessOver) add(surface.softnessOver->over);
  return bytes;
}

std::size_t answerSizeOf(const Commit& commit, const std::vector<std::string>& reports) {
  constexpr std::size_t kLengthAndTag_bytes = 6, kId_bytes = 10;  // at most
  std::size_t bytes = kId_bytes * commit.removed.size();
  for (const ObjectRecord& record : commit.put) bytes += wireSizeOf(record) + kLengthAndTag_bytes;
  for (const std::string& report : reports) bytes += report.size() + kLengthAndTag_bytes;
  return bytes;
}

}  // namespace haptics
