#include <algorithm>
#include <numbers>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

constexpr Range kFrictionCoefficient{0, 10};
constexpr Range kCrease{1e-9, std::numbers::pi, " rad (pi: no line is a crease by its angle)"};
constexpr Range kHeight{kMinTextureAmplitude_m, kMaxTextureAmplitude_m, " m"};
constexpr Range kVariation{-10, 10};
constexpr Range kVertexScale{0, 10};

Result<Shading> shadingFrom(const v1::Shading& message) {
  if (auto bad = checkAbove0(message.crease_rad(), kCrease, "crease_rad")) return refuse(bad);
  if (message.creases_size() > static_cast<int>(kMaxCreases)) {
    return refused("creases", "has " + std::to_string(message.creases_size()) + " entries; at most " +
                                  std::to_string(kMaxCreases) + " lines can be named, more by crease_rad");
  }
  Shading shading{message.crease_rad(), {}};
  for (const v1::Crease& given : message.creases()) {
    if (given.first() == given.second()) {
      return refused("creases[" + std::to_string(shading.creases.size()) + "]",
                     "names vertex " + std::to_string(given.first()) + " twice; a line has two");
    }
    shading.creases.push_back({given.first(), given.second()});
  }
  return shading;
}

struct FactorMapEdit {
  FactorMap map;
  FactorMapSource source;
};

Result<FactorMapEdit> perVertexFrom(const v1::PerVertex& message) {
  switch (message.source_case()) {
    case v1::PerVertex::kAsset:
      return hashFromWire(message.asset(), "per_vertex.asset").map([](const ContentHash& hash) {
        return FactorMapEdit{PerVertexScale{hash}, VertexValuesSource{AssetSource{hash}}};
      });
    case v1::PerVertex::kValues: {
      const auto& values = message.values().value();
      if (values.empty()) return refused("per_vertex.values.value", "is empty; give one for each vertex of the mesh");
      for (int i = 0; i < values.size(); ++i) {
        const std::string field = "per_vertex.values.value[" + std::to_string(i) + "]";
        if (auto bad = checkRange(values[i], kVertexScale, field)) return refuse(bad);
      }
      return FactorMapEdit{PerVertexScale{}, VertexValuesSource{GivenValues{{values.begin(), values.end()}}}};
    }
    case v1::PerVertex::kFile:
      if (auto bad = checkFilePath(message.file(), "per_vertex.file")) return refuse(bad);
      return FactorMapEdit{PerVertexScale{}, VertexValuesSource{FileSource{message.file()}}};
    case v1::PerVertex::SOURCE_NOT_SET:
      break;
  }
  return refused("per_vertex.source", "is missing; give values, file or asset");
}

/// A map as a message has it.
struct GivenMap {
  const v1::ScalarField* field;  ///< Null without, as per-vertex values.
  const v1::PerVertex* perVertex;
  double variation;
  std::string prefix;          ///< Of the fields' names.
  bool maybeConstant = false;  ///< Whether a variation of 0 says something.
};

Result<FactorMapEdit> mapFrom(const GivenMap& given) {
  const auto& [field, perVertex, variation, prefix, maybeConstant] = given;
  const std::string name = prefix + "variation";
  if (auto bad = checkRange(variation, kVariation, name)) return refuse(bad);
  if (field && variation == 0 && !maybeConstant) return refused(name, "is 0; the field would change nothing");
  if (!field && variation != 0) return refused(name, "is of a field, and there is none; give " + prefix + "field");
  FactorMapEdit edit;
  if (perVertex) {
    if (auto bad = take(perVertexFrom(*perVertex), edit, prefix)) return refuse(bad);
  } else if (field) {
    FieldEdit read;
    if (auto bad = take(fieldFrom(*field), read, prefix + "field.")) return refuse(bad);
    edit = {std::move(read.family), std::move(read.sources)};
  }
  return edit;
}

Result<FrictionEdit> frictionFrom(const v1::Friction& message) {
  if (auto bad = checkRange(message.mu_static(), kFrictionCoefficient, "mu_static")) return refuse(bad);
  if (auto bad = checkRange(message.mu_dynamic(), kFrictionCoefficient, "mu_dynamic")) return refuse(bad);
  if (message.mu_dynamic() > message.mu_static()) {
    return refuse(outside("mu_dynamic", message.mu_dynamic(),
                          "give at most mu_static, which is " + numberText(message.mu_static()) +
                              ": whatever slides would be held more than what sticks"));
  }
  auto both = mapFrom({.field = message.has_field() ? &message.field() : nullptr,
                       .perVertex = message.has_per_vertex() ? &message.per_vertex() : nullptr,
                       .variation = message.variation(),
                       .prefix = ""});
  if (!both) return tl::unexpected<Error>(std::move(both).error());
  auto dynamic = mapFrom({.field = message.has_dynamic_field() ? &message.dynamic_field() : nullptr,
                          .perVertex = message.has_dynamic_per_vertex() ? &message.dynamic_per_vertex() : nullptr,
                          .variation = message.dynamic_variation(),
                          .prefix = "dynamic_",
                          .maybeConstant = message.over_case() != v1::Friction::OVER_NOT_SET});
  if (!dynamic) return tl::unexpected<Error>(std::move(dynamic).error());
  return FrictionEdit{{.mu_static = message.mu_static(),
                       .mu_dynamic = message.mu_dynamic(),
                       .variation = message.variation(),
                       .over = std::move(both->map),
                       .dynamicVariation = message.dynamic_variation(),
                       .dynamicOver = std::move(dynamic->map)},
                      std::move(both->source),
                      std::move(dynamic->source)};
}

Result<SurfaceMapEdit> surfaceMapFrom(const v1::SurfaceMap& message) {
  if (message.over_case() == v1::SurfaceMap::OVER_NOT_SET && message.variation() == 0) {
    return refused("over", "is missing; give field or per_vertex");
  }
  auto edit = mapFrom({.field = message.has_field() ? &message.field() : nullptr,
                       .perVertex = message.has_per_vertex() ? &message.per_vertex() : nullptr,
                       .variation = message.variation(),
                       .prefix = ""});
  if (!edit) return tl::unexpected<Error>(std::move(edit).error());
  return SurfaceMapEdit{{message.variation(), std::move(edit->map)}, std::move(edit->source)};
}

Result<TextureEdit> textureFrom(const v1::Texture& message) {
  TextureEdit edit;
  Texture& texture = edit.texture;
  if (message.law() != v1::TEXTURE_LAW_UNSPECIFIED) {
    if (!v1::TextureLaw_IsValid(message.law())) {
      return refused("law", "is " + std::to_string(message.law()) + "; give TEXTURE_LAW_HO1999 or TEXTURE_LAW_BUMP");
    }
    texture.law = static_cast<Texture::Law>(message.law());
  }
  texture.amplitude_m = message.amplitude_m();
  texture.literal = message.literal();
  if (message.has_gain_k()) texture.gain_K = message.gain_k();
  if (auto bad = checkAbove0(texture.amplitude_m, kHeight, "amplitude_m")) return refuse(bad);
  if (auto bad = checkAbove0(texture.gain_K, {kMinGainK, kMaxGainK}, "gain_K")) return refuse(bad);
  FieldEdit field;
  if (auto bad = take(fieldFrom(message.field()), field, "field.")) return refuse(bad);
  texture.family = std::move(field.family);
  edit.sources = std::move(field.sources);
  return edit;
}

/// \param prefix of the ScalarField: "texture.field."
Refusal checkAnnounced(const std::vector<FamilySource>& sources, const std::string& prefix) {
  for (const FamilySource& source : sources) {
    const std::string field = prefix + fieldName(source);
    const auto* mapped = std::get_if<MappedSource>(&source);
    const bool isMade = mapped ? std::holds_alternative<AssetSource>(mapped->field)
                               : std::holds_alternative<AssetSource>(std::get<GrownSource>(source).points);
    if (!isMade) return Error{field + ".source", "is yet to be made; a state names an asset"};
    if (mapped && mapped->centreOfMesh) return Error{field + ".mapping.centre", "is missing"};
    if (mapped && mapped->sizeOfMesh) return Error{field + ".mapping.size_m", "is missing"};
  }
  return std::nullopt;
}

/// \param prefix of the map: "friction.", "friction.dynamic_"
Refusal checkAnnounced(const FactorMapSource& source, const std::string& prefix) {
  if (const auto* fields = std::get_if<std::vector<FamilySource>>(&source)) {
    return checkAnnounced(*fields, prefix + "field.");
  }
  if (std::holds_alternative<AssetSource>(std::get<VertexValuesSource>(source))) return std::nullopt;
  return Error{prefix + "per_vertex.source", "is no asset; a state names one"};
}

Result<Friction> announcedFriction(const v1::Friction& message) {
  FrictionEdit edit;
  if (auto bad = take(frictionFrom(message), edit, "friction.")) return refuse(bad);
  if (auto bad = checkAnnounced(edit.source, "friction.")) return refuse(bad);
  if (auto bad = checkAnnounced(edit.dynamicSource, "friction.dynamic_")) return refuse(bad);
  return std::move(edit.friction);
}

Result<Texture> announcedTexture(const v1::Texture& message) {
  TextureEdit edit;
  if (auto bad = take(textureFrom(message), edit, "texture.")) return refuse(bad);
  if (auto bad = checkAnnounced(edit.sources, "texture.field.")) return refuse(bad);
  return std::move(edit.texture);
}

/// \param prefix "stiffness_over."
Result<SurfaceMap> announcedMap(const v1::SurfaceMap& message, const std::string& prefix) {
  SurfaceMapEdit edit;
  if (auto bad = take(surfaceMapFrom(message), edit, prefix)) return refuse(bad);
  if (auto bad = checkAnnounced(edit.source, prefix)) return refuse(bad);
  return std::move(edit.map);
}

void write(const Shading& shading, v1::Shading& message) {
  message.set_crease_rad(shading.crease_rad);
  for (const Crease& crease : shading.creases) {
    v1::Crease& to = *message.add_creases();
    to.set_first(crease[0]);
    to.set_second(crease[1]);
  }
}

/// \param message a Friction or a SurfaceMap
void writeOver(const FactorMap& over, auto& message) {
  if (const auto* field = std::get_if<FieldFamily>(&over)) toWire(*field, *message.mutable_field());
  if (const auto* scale = std::get_if<PerVertexScale>(&over)) {
    message.mutable_per_vertex()->set_asset(scale->values.asBytes());
  }
}

void write(const Friction& friction, v1::Friction& message) {
  message.set_mu_static(friction.mu_static);
  message.set_mu_dynamic(friction.mu_dynamic);
  message.set_variation(friction.variation);
  writeOver(friction.over, message);
  message.set_dynamic_variation(friction.dynamicVariation);
  if (const auto* field = std::get_if<FieldFamily>(&friction.dynamicOver)) {
    toWire(*field, *message.mutable_dynamic_field());
  }
  if (const auto* scale = std::get_if<PerVertexScale>(&friction.dynamicOver)) {
    message.mutable_dynamic_per_vertex()->set_asset(scale->values.asBytes());
  }
}

void write(const SurfaceMap& map, v1::SurfaceMap& message) {
  message.set_variation(map.variation);
  writeOver(map.over, message);
}

void write(const Texture& texture, v1::Texture& message) {
  message.set_law(static_cast<v1::TextureLaw>(texture.law));
  toWire(texture.family, *message.mutable_field());
  message.set_amplitude_m(texture.amplitude_m);
  message.set_literal(texture.literal);
  message.set_gain_k(texture.gain_K);
}

// What an edit gives, in the form in which records hold it.

void tidy(Shading& shading) {
  for (Crease& crease : shading.creases) std::ranges::sort(crease);
  std::ranges::sort(shading.creases);
  shading.creases.erase(std::unique(shading.creases.begin(), shading.creases.end()), shading.creases.end());
}
void tidy(FactorMap& map) {
  if (auto* field = std::get_if<FieldFamily>(&map)) normalise(*field);
}
void tidy(FrictionEdit& edit) {
  tidy(edit.friction.over);
  tidy(edit.friction.dynamicOver);
}
void tidy(TextureEdit& edit) { normalise(edit.texture.family); }
void tidy(SurfaceMapEdit& edit) { tidy(edit.map.over); }

template <class Message, class T>
Refusal takeTidy(bool given, const Message& message, Result<T> (*from)(const Message&),
                 std::optional<std::optional<T>>& to, const std::string& prefix) {
  auto bad = takeEdit(given, message, from, to, prefix);
  if (!bad && to && *to) tidy(**to);
  return bad;
}

}  // namespace

Result<SurfaceEdit> surfaceFrom(const v1::Material& message) {
  SurfaceEdit edit;
  auto bad = takeTidy(message.has_shading(), message.shading(), shadingFrom, edit.shading, "shading.");
  if (!bad) bad = takeTidy(message.has_friction(), message.friction(), frictionFrom, edit.friction, "friction.");
  if (!bad) bad = takeTidy(message.has_texture(), message.texture(), textureFrom, edit.texture, "texture.");
  if (!bad) {
    bad = takeTidy(message.has_stiffness_over(), message.stiffness_over(), surfaceMapFrom, edit.stiffnessOver,
                   "stiffness_over.");
  }
  if (!bad) {
    bad = takeTidy(message.has_softness_over(), message.softness_over(), surfaceMapFrom, edit.softnessOver,
                   "softness_over.");
  }
  if (bad) return refuse(bad);
  return edit;
}

Result<SurfaceProperties> surfaceFrom(const v1::ObjectState& message) {
  SurfaceProperties to;
  if (message.has_shading()) {
    if (auto bad = take(shadingFrom(message.shading()), to.shading, "shading.")) return refuse(bad);
  }
  if (message.has_friction()) {
    if (auto bad = take(announcedFriction(message.friction()), to.friction)) return refuse(bad);
  }
  if (message.has_texture()) {
    if (auto bad = take(announcedTexture(message.texture()), to.texture)) return refuse(bad);
  }
  if (message.has_stiffness_over()) {
    auto map = announcedMap(message.stiffness_over(), "stiffness_over.");
    if (auto bad = take(std::move(map), to.stiffnessOver)) return refuse(bad);
  }
  if (message.has_softness_over()) {
    auto map = announcedMap(message.softness_over(), "softness_over.");
    if (auto bad = take(std::move(map), to.softnessOver)) return refuse(bad);
  }
  return to;
}

void toWire(const SurfaceProperties& properties, v1::ObjectState& message) {
  message.clear_shading();
  message.clear_friction();
  message.clear_texture();
  message.clear_stiffness_over();
  message.clear_softness_over();
  if (properties.shading) write(*properties.shading, *message.mutable_shading());
  if (properties.friction) write(*properties.friction, *message.mutable_friction());
  if (properties.texture) write(*properties.texture, *message.mutable_texture());
  if (properties.stiffnessOver) write(*properties.stiffnessOver, *message.mutable_stiffness_over());
  if (properties.softnessOver) write(*properties.softnessOver, *message.mutable_softness_over());
}

}  // namespace haptics
