#include "haptic_server/scene/scene_limits.h"

#include <string>
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
    const auto* file = mapped ? std::get_if<FileSource>(&mapped->field)
                              : std::get_if<FileSource>(&std::get<GrownSource>(source).points);
    if (file) bytes += heldBy(file->path);
  }
  return bytes;
}

std::size_t heldBy(const FactorMap& map, const FactorMapSource& source) noexcept {
  std::size_t bytes = 0;
  if (const auto* family = std::get_if<FieldFamily>(&map)) bytes += heldBy(*family);
  if (const auto* fields = std::get_if<std::vector<FamilySource>>(&source)) return bytes + heldBy(*fields);
  const auto& values = std::get<VertexValuesSource>(source);
  if (const auto* file = std::get_if<FileSource>(&values)) return bytes + heldBy(file->path);
  const auto* given = std::get_if<GivenValues>(&values);
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
  const auto* file = edit.residue && *edit.residue ? std::get_if<FileSource>(&**edit.residue) : nullptr;
  return (edit.lattice && *edit.lattice ? heldBy((*edit.lattice)->control_m) : 0) + (file ? heldBy(file->path) : 0);
}

std::size_t heldBy(const std::optional<MotionProperties>& motion) noexcept {
  return motion ? heldBy(motion->planes) : 0;
}

std::size_t heldBy(const std::vector<Effect>& effects) noexcept {
  std::size_t bytes = effects.capacity() * sizeof(Effect);
  for (const Effect& effect : effects) {
    bytes += heldBy(effect.path_m) + heldBy(effect.samples) + heldBy(effect.speeds_m_per_s) + heldBy(effect.forces_N) +
             heldBy(effect.models);
  }
  return bytes;
}

std::size_t heldBy(const MeshSource& mesh) noexcept {
  const auto* file = std::get_if<FileSource>(&mesh.source);
  return file ? heldBy(file->path) : 0;
}

struct HeldByOperation {
  std::size_t operator()(const AddObject& op) const noexcept {
    return heldBy(op.name) + heldBy(op.mesh) + heldBy(op.material.surface) + heldBy(op.motion) +
           heldBy(op.deformation) + heldBy(op.effects);
  }
  std::size_t operator()(const RemoveObject& op) const noexcept { return heldBy(op.object); }
  std::size_t operator()(const RemeshObject& op) const noexcept { return heldBy(op.object) + heldBy(op.mesh); }
  std::size_t operator()(const SetPose& op) const noexcept { return heldBy(op.object); }
  std::size_t operator()(const SetMaterial& op) const noexcept {
    return heldBy(op.object) + heldBy(op.material.surface);
  }
  std::size_t operator()(const SetMotion& op) const noexcept { return heldBy(op.object) + heldBy(op.motion); }
  std::size_t operator()(const SetDeformation& op) const noexcept { return heldBy(op.object) + heldBy(op.deformation); }
  std::size_t operator()(const SetEffects& op) const noexcept { return heldBy(op.object) + heldBy(op.effects); }
};

}  // namespace

std::size_t detailSizeOf(const ObjectRecord& record) {
  constexpr std::size_t kCrease_bytes = 16, kControlPoint_bytes = 12, kPathPoint_bytes = 24, kSample_bytes = 4,
                        kNumber_bytes = 8;
  const SurfaceProperties& surface = record.material.surface;
  std::size_t bytes = 0;
  if (record.deformation.lattice) bytes += kControlPoint_bytes * record.deformation.lattice->control_m.size();
  for (const Effect& effect : record.effects)
    bytes += kPathPoint_bytes * effect.path_m.size() + kSample_bytes * effect.samples.size() +
             kNumber_bytes * (effect.speeds_m_per_s.size() + effect.forces_N.size() + effect.models.size());
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

std::size_t memoryOf_bytes(const Transaction& transaction) noexcept {
  std::size_t bytes = sizeof transaction + heldBy(transaction.preconditions) + heldBy(transaction.operations);
  for (const Precondition& precondition : transaction.preconditions) bytes += heldBy(precondition.object);
  for (const Operation& operation : transaction.operations) bytes += std::visit(HeldByOperation{}, operation);
  return bytes;
}

}  // namespace haptics
