#include "common/scene/surface_properties.h"

#include "common/scene/surface_edits.h"

namespace haptics {
namespace {

// Each record in the order of its declaration; before what may be there or not, and before alternatives and lists, a
// number that says which or how many: no two records give the same bytes.

/// In an object's hash motion and deformation have the numbers between.
enum class Property : std::uint64_t {
  kShading = 1,
  kFriction,
  kTexture,
  kDynamicFriction = 9,
  kStiffnessMap,
  kSoftnessMap,
  kScalar = 13
};

template <class T>
void addNumber(Hasher& h, T value) {
  h.add(static_cast<std::uint64_t>(value));
}

void add(Hasher& h, const FourierFamily& family) {
  addNumber(h, family.terms.size());
  for (const FourierTerm& term : family.terms) {
    h.add(term.amplitude);
    h.add(term.direction);
    h.add(term.wavelength_m).add(term.phase_rad);
  }
}

void add(Hasher& h, const NoiseFamily& family) {
  h.add(family.wavelength_m);
  addNumber(h, family.octaves);
  h.add(family.persistence);
  addNumber(h, family.seed);
}

void add(Hasher& h, const CellularFamily& family) {
  h.add(family.cell_m).add(family.smoothness);
  addNumber(h, family.seed);
}

void add(Hasher& h, const GrainFamily& family) {
  h.add(family.grain_m);
  addNumber(h, family.seed);
}

void add(Hasher& h, const MappedFamily& family) {
  const Mapping& m = family.mapping;
  h.add(family.field);
  addNumber(h, m.shape);
  h.add(m.centre);
  h.add(m.rotation.w).add(m.rotation.x).add(m.rotation.y).add(m.rotation.z);
  h.add(m.size_m);
  h.add(m.tile_m);
}

void add(Hasher& h, const GrownFamily& family) { h.add(family.points); }

void add(Hasher& h, const LayeredFamily& family);

void add(Hasher&, std::monostate) {}
void add(Hasher& h, const PerVertexScale& scale) { h.add(scale.values); }

template <class... Alternatives>
void add(Hasher& h, const std::variant<Alternatives...>& chosen) {
  addNumber(h, chosen.index());
  std::visit([&h](const auto& alternative) { add(h, alternative); }, chosen);
}

void add(Hasher& h, const LayeredFamily& family) {
  addNumber(h, family.combination);
  addNumber(h, family.layers.size());
  for (const FieldLayer& layer : family.layers) {
    h.add(layer.weight);
    add(h, layer.family);
  }
}

void add(Hasher& h, const Shading& shading) {
  h.add(shading.crease_rad);
  addNumber(h, shading.creases.size());
  for (const Crease& crease : shading.creases) {
    addNumber(h, crease[0]);
    addNumber(h, crease[1]);
  }
}

void add(Hasher& h, const Friction& friction) {
  h.add(friction.mu_static).add(friction.mu_dynamic).add(friction.variation);
  add(h, friction.over);
  if (std::holds_alternative<std::monostate>(friction.dynamicOver)) return;
  addNumber(h, Property::kDynamicFriction);
  h.add(friction.dynamicVariation);
  add(h, friction.dynamicOver);
}

void add(Hasher& h, const Texture& texture) {
  addNumber(h, texture.law);
  add(h, texture.family);
  h.add(texture.amplitude_m);
  addNumber(h, texture.literal);
  h.add(texture.gain_K);
}

void add(Hasher& h, const SurfaceMap& map) {
  h.add(map.variation);
  add(h, map.over);
}

template <class T>
void addIfThere(Hasher& h, Property which, const std::optional<T>& property) {
  if (!property) return;
  addNumber(h, which);
  add(h, *property);
}

/// \param look takes the kind and hash of an asset; of a hash that may be changed where the properties may.
void lookAtField(auto& family, const auto& look) {
  if (auto* mapped = std::get_if<MappedFamily>(&family)) look(AssetKind::kScalarField, mapped->field);
  if (auto* grown = std::get_if<GrownFamily>(&family)) look(AssetKind::kPointField, grown->points);
  if (auto* layered = std::get_if<LayeredFamily>(&family)) {
    for (auto& layer : layered->layers) lookAtField(layer.family, look);
  }
}

void lookAtMap(auto& map, const auto& look) {
  if (auto* field = std::get_if<FieldFamily>(&map)) lookAtField(*field, look);
  if (auto* scale = std::get_if<PerVertexScale>(&map)) look(AssetKind::kVertexValues, scale->values);
}

void lookAtAssets(auto& properties, const auto& look) {
  if (properties.friction) {
    lookAtMap(properties.friction->over, look);
    lookAtMap(properties.friction->dynamicOver, look);
  }
  if (properties.texture) lookAtField(properties.texture->family, look);
  if (properties.stiffnessOver) lookAtMap(properties.stiffnessOver->over, look);
  if (properties.softnessOver) lookAtMap(properties.softnessOver->over, look);
}

/// \param part the edit's record
template <class T, class Edit>
void take(std::optional<T>& property, const std::optional<std::optional<Edit>>& edit, T Edit::*part) {
  if (!edit) return;
  property.reset();
  if (*edit) property = (**edit).*part;
}

}  // namespace

FactorMapSource::FactorMapSource() noexcept = default;
FactorMapSource::FactorMapSource(const FactorMapSource&) = default;
FactorMapSource::FactorMapSource(FactorMapSource&&) noexcept = default;
FactorMapSource& FactorMapSource::operator=(const FactorMapSource&) = default;
FactorMapSource& FactorMapSource::operator=(FactorMapSource&&) noexcept = default;
FactorMapSource::~FactorMapSource() = default;

std::string fieldName(const FamilySource& source) {
  const char* family = std::holds_alternative<MappedSource>(source) ? "mapped" : "grown";
  const auto layer = layerOf(source);
  return (layer ? layerField(*layer) : "") + family;
}

std::optional<std::size_t> layerOf(const FamilySource& source) {
  return std::visit([](const auto& chosen) { return chosen.layer; }, source);
}

void addTo(Hasher& hasher, const SurfaceProperties& properties) {
  addIfThere(hasher, Property::kShading, properties.shading);
  addIfThere(hasher, Property::kFriction, properties.friction);
  addIfThere(hasher, Property::kTexture, properties.texture);
  addIfThere(hasher, Property::kStiffnessMap, properties.stiffnessOver);
  addIfThere(hasher, Property::kSoftnessMap, properties.softnessOver);
  const auto addScalar = [&hasher](std::string_view name, double value) {
    if (value == 0) return;
    addNumber(hasher, Property::kScalar);
    hasher.add(name).add(value);
  };
  forEachScalar(addScalar, properties.scalars);
}

std::vector<AssetName> assetsOf(const SurfaceProperties& properties) {
  std::vector<AssetName> names;
  lookAtAssets(properties, [&](AssetKind kind, const ContentHash& hash) { names.push_back({kind, hash}); });
  return names;
}

SurfaceProperties renamed(SurfaceProperties properties, const std::function<ContentHash(const AssetName&)>& rename) {
  lookAtAssets(properties, [&](AssetKind kind, ContentHash& hash) { hash = rename({kind, hash}); });
  return properties;
}

SurfaceProperties edited(SurfaceProperties properties, const SurfaceEdit& edit) {
  if (edit.shading) properties.shading = *edit.shading;
  take(properties.friction, edit.friction, &FrictionEdit::friction);
  take(properties.texture, edit.texture, &TextureEdit::texture);
  take(properties.stiffnessOver, edit.stiffnessOver, &SurfaceMapEdit::map);
  take(properties.softnessOver, edit.softnessOver, &SurfaceMapEdit::map);
  const auto takeScalar = [](std::string_view /*name*/, double& value, const std::optional<double>& given) {
    value = given.value_or(value);
  };
  forEachScalar(takeScalar, properties.scalars, edit.scalars);
  return properties;
}

}  // namespace haptics
