#include "haptic_server/scene/queued_size.h"

#include <string>
#include <variant>
#include <vector>

namespace haptics {
namespace {

// What each holds beside itself.

template <class T>
std::size_t heldBy(const std::vector<T>& list) noexcept {
  return list.capacity() * sizeof(T);
}

std::size_t heldBy(const std::string& text) noexcept { return text.capacity(); }

std::size_t heldBy(const ObjectRef& object) noexcept {
  const auto* name = std::get_if<std::string>(&object.value);
  return name ? heldBy(*name) : 0;
}

std::size_t heldBy(const FieldFamily& family) noexcept {
  if (const auto* fourier = std::get_if<FourierFamily>(&family)) return heldBy(fourier->terms);
  const auto* layered = std::get_if<LayeredFamily>(&family);
  if (!layered) return 0;
  std::size_t bytes = heldBy(layered->layers);
  for (const FieldLayer& layer : layered->layers) bytes += heldBy(layer.family);
  return bytes;
}

std::size_t heldBy(const std::vector<FamilySource>& sources) noexcept {
  std::size_t bytes = sources.capacity() * sizeof(FamilySource);
  for (const FamilySource& source : sources) {
    const auto* mapped = std::get_if<MappedSource>(&source);
    const auto* file = mapped ? std::get_if<FileSource>(&mapped->field) : nullptr;
    if (file) bytes += heldBy(file->path);
  }
  return bytes;
}

std::size_t heldBy(const FactorMap& map, const FactorMapSource& source) noexcept {
  std::size_t bytes = 0;
  if (const auto* family = std::get_if<FieldFamily>(&map)) bytes += heldBy(*family);
  if (const auto* fields = std::get_if<std::vector<FamilySource>>(&source)) return bytes + heldBy(*fields);
  const auto* given = std::get_if<GivenValues>(&std::get<VertexValuesSource>(source));
  return given ? bytes + heldBy(given->values) : bytes;
}

std::size_t heldBy(const FrictionEdit& edit) noexcept {
  return heldBy(edit.friction.over, edit.source) + heldBy(edit.friction.dynamicOver, edit.dynamicSource);
}

std::size_t heldBy(const SurfaceEdit& edit) noexcept {
  std::size_t bytes = 0;
  if (edit.shading && *edit.shading) bytes += heldBy((*edit.shading)->creases);
  if (edit.friction && *edit.friction) bytes += heldBy(**edit.friction);
  for (const auto& map : {&edit.stiffnessOver, &edit.softnessOver}) {
    if (*map && **map) bytes += heldBy((**map)->map.over, (**map)->source);
  }
  if (!edit.texture || !*edit.texture) return bytes;
  const TextureEdit& texture = **edit.texture;
  return bytes + heldBy(texture.texture.family) + heldBy(texture.sources);
}

std::size_t heldBy(const DeformationEdit& edit) noexcept {
  return edit.lattice && *edit.lattice ? heldBy((*edit.lattice)->control_m) : 0;
}

std::size_t heldBy(const std::optional<MotionProperties>& motion) noexcept {
  return motion ? heldBy(motion->planes) : 0;
}

std::size_t heldBy(const MeshSource& mesh) noexcept {
  const auto* file = std::get_if<FileSource>(&mesh.source);
  return file ? heldBy(file->path) : 0;
}

struct HeldByOperation {
  std::size_t operator()(const AddObject& op) const noexcept {
    return heldBy(op.name) + heldBy(op.mesh) + heldBy(op.material.surface) + heldBy(op.motion) + heldBy(op.deformation);
  }
  std::size_t operator()(const RemoveObject& op) const noexcept { return heldBy(op.object); }
  std::size_t operator()(const RemeshObject& op) const noexcept { return heldBy(op.object) + heldBy(op.mesh); }
  std::size_t operator()(const SetPose& op) const noexcept { return heldBy(op.object); }
  std::size_t operator()(const SetMaterial& op) const noexcept {
    return heldBy(op.object) + heldBy(op.material.surface);
  }
  std::size_t operator()(const SetMotion& op) const noexcept { return heldBy(op.object) + heldBy(op.motion); }
  std::size_t operator()(const SetDeformation& op) const noexcept { return heldBy(op.object) + heldBy(op.deformation); }
};

}  // namespace

std::size_t memoryOf_bytes(const Transaction& transaction) noexcept {
  std::size_t bytes = sizeof transaction + heldBy(transaction.preconditions) + heldBy(transaction.operations);
  for (const Precondition& precondition : transaction.preconditions) bytes += heldBy(precondition.object);
  for (const Operation& operation : transaction.operations) bytes += std::visit(HeldByOperation{}, operation);
  return bytes;
}

}  // namespace haptics
