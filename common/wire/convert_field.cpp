#include <algorithm>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

constexpr Range kWavelength_m{kMinWavelength_m, kMaxCoordinate_m, " m"};
constexpr Range kAmplitude{-1000, 1000};
constexpr Range kPhase_rad{-1000, 1000, " rad"};
constexpr Range kOctaves{1, 12};
constexpr Range kPersistence{0.01, 1};
constexpr Range kSmoothness{0.001, 1};
constexpr Range kCells{2, 32};  // computing the most takes seconds
constexpr Range kElongation{1, 8};
constexpr Range kResolution{32, 1024};
constexpr std::uint32_t kMinPerCell = 8;  // samples: fewer do not show a cell's shape

Result<FieldEdit> fourierFrom(const v1::FourierField& message) {
  if (message.terms().empty() || message.terms_size() > static_cast<int>(kMaxFourierTerms)) {
    return refused("fourier.terms", "has " + std::to_string(message.terms_size()) + " entries; give 1 to " +
                                        std::to_string(kMaxFourierTerms));
  }
  FourierFamily family;
  for (const v1::FourierTerm& given : message.terms()) {
    const std::string field = "fourier.terms[" + std::to_string(family.terms.size()) + "].";
    FourierTerm term{.amplitude = given.has_amplitude() ? given.amplitude() : 1,
                     .direction = vectorFrom(given.direction()),
                     .wavelength_m = given.wavelength_m(),
                     .phase_rad = given.phase_rad()};
    if (auto bad = checkRange(term.amplitude, kAmplitude, field + "amplitude")) return refuse(bad);
    if (term.amplitude == 0) return refused(field + "amplitude", "is 0; the term would be nothing: leave it out");
    if (auto bad = checkUnitVector(given.direction(), field + "direction")) return refuse(bad);
    if (auto bad = checkRange(term.wavelength_m, kWavelength_m, field + "wavelength_m")) return refuse(bad);
    if (auto bad = checkRange(term.phase_rad, kPhase_rad, field + "phase_rad")) return refuse(bad);
    family.terms.push_back(term);
  }
  return FieldEdit{std::move(family), {}};
}

Result<FieldEdit> noiseFrom(const v1::NoiseField& message) {
  NoiseFamily family{.wavelength_m = message.wavelength_m()};
  if (message.has_octaves()) family.octaves = message.octaves();
  if (message.has_persistence()) family.persistence = message.persistence();
  if (message.has_seed()) family.seed = message.seed();
  if (auto bad = checkRange(family.wavelength_m, kWavelength_m, "noise.wavelength_m")) return refuse(bad);
  if (auto bad = checkRange(family.octaves, kOctaves, "noise.octaves")) return refuse(bad);
  if (auto bad = checkRange(family.persistence, kPersistence, "noise.persistence")) return refuse(bad);
  return FieldEdit{family, {}};
}

Result<FieldEdit> cellularFrom(const v1::CellularField& message) {
  CellularFamily family{.cell_m = message.cell_m()};
  if (message.has_smoothness()) family.smoothness = message.smoothness();
  if (message.has_seed()) family.seed = message.seed();
  if (auto bad = checkRange(family.cell_m, kWavelength_m, "cellular.cell_m")) return refuse(bad);
  if (auto bad = checkRange(family.smoothness, kSmoothness, "cellular.smoothness")) return refuse(bad);
  return FieldEdit{family, {}};
}

Result<FieldEdit> grainFrom(const v1::GrainField& message) {
  GrainFamily family{.grain_m = message.grain_m()};
  if (message.has_seed()) family.seed = message.seed();
  if (auto bad = checkRange(family.grain_m, kWavelength_m, "grain.grain_m")) return refuse(bad);
  return FieldEdit{family, {}};
}

/// 0, which is how an absent number arrives, stands for the default.
Refusal readGrid(const auto& message, auto& source, const std::string& field) {
  if (message.cells() != 0) source.cells = message.cells();
  if (message.resolution() != 0) source.resolution = message.resolution();
  if (auto bad = checkRange(source.cells, kCells, field + "cells")) return bad;
  if (auto bad = checkRange(source.resolution, kResolution, field + "resolution")) return bad;
  const std::uint32_t least = kMinPerCell * source.cells;
  if (source.resolution >= least) return std::nullopt;
  return Error{field + "resolution", "is " + std::to_string(source.resolution) + "; " + std::to_string(source.cells) +
                                         " cells need " + std::to_string(least) + " or more"};
}

Refusal readPattern(v1::ReactionDiffusionPattern given, ReactionDiffusionSource::Pattern& to) {
  if (given == v1::REACTION_DIFFUSION_PATTERN_UNSPECIFIED) return std::nullopt;
  if (!v1::ReactionDiffusionPattern_IsValid(given)) {
    return Error{"reaction_diffusion.pattern",
                 "is " + std::to_string(given) + "; give REACTION_DIFFUSION_PATTERN_SPOTS or _STRIPES"};
  }
  to = static_cast<ReactionDiffusionSource::Pattern>(given);
  return std::nullopt;
}

Result<FieldSource> reactionDiffusionFrom(const v1::ReactionDiffusion& message) {
  ReactionDiffusionSource source;
  if (auto bad = readPattern(message.pattern(), source.pattern)) return refuse(bad);
  if (message.has_seed()) source.seed = message.seed();
  if (auto bad = readGrid(message, source, "reaction_diffusion.")) return refuse(bad);
  return FieldSource{source};
}

Result<FieldSource> spotNoiseFrom(const v1::SpotNoise& message) {
  SpotNoiseSource source;
  if (message.has_elongation()) source.elongation = message.elongation();
  if (message.has_seed()) source.seed = message.seed();
  if (auto bad = checkRange(source.elongation, kElongation, "spot_noise.elongation")) return refuse(bad);
  if (auto bad = readGrid(message, source, "spot_noise.")) return refuse(bad);
  return FieldSource{source};
}

Result<FieldSource> sourceFrom(const v1::MappedField& message) {
  switch (message.source_case()) {
    case v1::MappedField::kImage:
      if (auto bad = checkFilePath(message.image(), "image")) return refuse(bad);
      return FieldSource{FileSource{message.image()}};
    case v1::MappedField::kAsset:
      return hashFromWire(message.asset(), "asset").map([](const ContentHash& hash) {
        return FieldSource{AssetSource{hash}};
      });
    case v1::MappedField::kReactionDiffusion:
      return reactionDiffusionFrom(message.reaction_diffusion());
    case v1::MappedField::kSpotNoise:
      return spotNoiseFrom(message.spot_noise());
    case v1::MappedField::SOURCE_NOT_SET:
      break;
  }
  return refused("source", "is missing; give image, asset, reaction_diffusion or spot_noise");
}

Result<Mapping> mappingFrom(const v1::Mapping& message) {
  Mapping mapping;
  if (message.shape() == v1::MAPPING_SHAPE_UNSPECIFIED || !v1::MappingShape_IsValid(message.shape())) {
    return refused("mapping.shape",
                   "is " + std::to_string(message.shape()) + "; give MAPPING_SHAPE_PLANE, _CUBE, _CYLINDER or _SPHERE");
  }
  mapping.shape = static_cast<Mapping::Shape>(message.shape());
  mapping.centre = vectorFrom(message.centre());
  mapping.tile_m = message.tile_m();
  if (message.has_size_m()) {
    mapping.size_m = vectorFrom(message.size_m());
    if (auto bad = checkSize(message.size_m(), "mapping.size_m")) return refuse(bad);
  }
  if (auto bad = checkPosition(message.centre(), "mapping.centre")) return refuse(bad);
  if (message.has_rotation()) {
    if (auto bad = checkRotation(message.rotation(), "mapping.rotation")) return refuse(bad);
    mapping.rotation = rotationFrom(message.rotation());
  }
  if (auto bad = checkRange(mapping.tile_m, kWavelength_m, "mapping.tile_m")) return refuse(bad);
  return mapping;
}

Result<FieldEdit> mappedFrom(const v1::MappedField& message) {
  const v1::Mapping& given = message.mapping();
  MappedSource source{{}, !given.has_centre(), !given.has_size_m()};
  MappedFamily family;
  if (auto bad = take(sourceFrom(message), source.field, "mapped.")) return refuse(bad);
  if (auto bad = take(mappingFrom(given), family.mapping, "mapped.")) return refuse(bad);
  if (const auto* asset = std::get_if<AssetSource>(&source.field)) family.field = asset->hash;
  return FieldEdit{family, {std::move(source)}};
}

Result<PointFieldSource> sourceFrom(const v1::GrownField& message) {
  switch (message.source_case()) {
    case v1::GrownField::kAsset:
      return hashFromWire(message.asset(), "asset").map([](const ContentHash& hash) {
        return PointFieldSource{AssetSource{hash}};
      });
    case v1::GrownField::kReactionDiffusion: {
      const v1::GrownReactionDiffusion& given = message.reaction_diffusion();
      GrownReactionDiffusionSource source;
      if (auto bad = readPattern(given.pattern(), source.pattern)) return refuse(bad);
      source.wavelength_m = given.wavelength_m();
      if (given.has_seed()) source.seed = given.seed();
      if (auto bad = checkRange(source.wavelength_m, kWavelength_m, "reaction_diffusion.wavelength_m"))
        return refuse(bad);
      return PointFieldSource{source};
    }
    case v1::GrownField::kFile:
      if (auto bad = checkFilePath(message.file(), "file")) return refuse(bad);
      return PointFieldSource{FileSource{message.file()}};
    case v1::GrownField::SOURCE_NOT_SET:
      break;
  }
  return refused("source", "is missing; give file, asset or reaction_diffusion");
}

Result<FieldEdit> grownFrom(const v1::GrownField& message) {
  GrownSource source;
  GrownFamily family;
  if (auto bad = take(sourceFrom(message), source.points, "grown.")) return refuse(bad);
  if (const auto* asset = std::get_if<AssetSource>(&source.points)) family.points = asset->hash;
  return FieldEdit{family, {source}};
}

Result<FieldEdit> layersFrom(const v1::LayeredField& message) {
  constexpr int kMinLayers = 2;
  if (message.layer_size() < kMinLayers || message.layer_size() > static_cast<int>(kMaxLayers)) {
    return refused("layers.layer", "has " + std::to_string(message.layer_size()) + " entries; give " +
                                       std::to_string(kMinLayers) + " to " + std::to_string(kMaxLayers));
  }
  LayeredFamily family;
  if (message.combination() != v1::LAYER_COMBINATION_UNSPECIFIED) {
    if (!v1::LayerCombination_IsValid(message.combination())) {
      return refused("layers.combination", "is " + std::to_string(message.combination()) +
                                               "; give LAYER_COMBINATION_SUM or LAYER_COMBINATION_PRODUCT");
    }
    family.combination = static_cast<LayeredFamily::Combination>(message.combination());
  }
  std::vector<FamilySource> sources;
  for (const v1::FieldLayer& given : message.layer()) {
    const std::size_t number = family.layers.size();
    const std::string weightField = "layers.layer[" + std::to_string(number) + "].weight";
    const double weight = given.has_weight() ? given.weight() : 1;
    if (auto bad = checkRange(weight, kAmplitude, weightField)) return refuse(bad);
    if (weight == 0) return refused(weightField, "is 0; give another, or leave the layer out");
    if (given.field().has_layers()) {
      return refused(layerField(number) + "layers",
                     "is layered within a layer; give a layer a field of another family");
    }
    FieldEdit layer;
    if (auto bad = take(fieldFrom(given.field()), layer, layerField(number))) return refuse(bad);
    for (FamilySource& source : layer.sources) {
      std::visit([number](auto& chosen) { chosen.layer = number; }, source);
      sources.push_back(std::move(source));
    }
    family.layers.push_back({weight, std::move(layer.family)});
  }
  return FieldEdit{std::move(family), std::move(sources)};
}

void write(const FourierFamily& family, v1::ScalarField& message) {
  for (const FourierTerm& term : family.terms) {
    v1::FourierTerm& to = *message.mutable_fourier()->add_terms();
    to.set_amplitude(term.amplitude);
    toWire(term.direction, *to.mutable_direction());
    to.set_wavelength_m(term.wavelength_m);
    to.set_phase_rad(term.phase_rad);
  }
}

void write(const NoiseFamily& family, v1::ScalarField& message) {
  v1::NoiseField& to = *message.mutable_noise();
  to.set_wavelength_m(family.wavelength_m);
  to.set_octaves(family.octaves);
  to.set_persistence(family.persistence);
  to.set_seed(family.seed);
}

void write(const CellularFamily& family, v1::ScalarField& message) {
  v1::CellularField& to = *message.mutable_cellular();
  to.set_cell_m(family.cell_m);
  to.set_smoothness(family.smoothness);
  to.set_seed(family.seed);
}

void write(const GrainFamily& family, v1::ScalarField& message) {
  message.mutable_grain()->set_grain_m(family.grain_m);
  message.mutable_grain()->set_seed(family.seed);
}

void write(const MappedFamily& family, v1::ScalarField& message) {
  v1::MappedField& to = *message.mutable_mapped();
  to.set_asset(family.field.asBytes());
  v1::Mapping& mapping = *to.mutable_mapping();
  mapping.set_shape(static_cast<v1::MappingShape>(family.mapping.shape));
  toWire(family.mapping.centre, *mapping.mutable_centre());
  toWire(family.mapping.rotation, *mapping.mutable_rotation());
  toWire(family.mapping.size_m, *mapping.mutable_size_m());
  mapping.set_tile_m(family.mapping.tile_m);
}

void write(const GrownFamily& family, v1::ScalarField& message) {
  message.mutable_grown()->set_asset(family.points.asBytes());
}

void write(const LayeredFamily& family, v1::ScalarField& message) {
  v1::LayeredField& to = *message.mutable_layers();
  to.set_combination(static_cast<v1::LayerCombination>(family.combination));
  for (const FieldLayer& layer : family.layers) {
    v1::FieldLayer& added = *to.add_layer();
    added.set_weight(layer.weight);
    toWire(layer.family, *added.mutable_field());
  }
}

}  // namespace

Result<FieldEdit> fieldFrom(const v1::ScalarField& message) {
  switch (message.family_case()) {
    case v1::ScalarField::kFourier:
      return fourierFrom(message.fourier());
    case v1::ScalarField::kNoise:
      return noiseFrom(message.noise());
    case v1::ScalarField::kCellular:
      return cellularFrom(message.cellular());
    case v1::ScalarField::kGrain:
      return grainFrom(message.grain());
    case v1::ScalarField::kMapped:
      return mappedFrom(message.mapped());
    case v1::ScalarField::kLayers:
      return layersFrom(message.layers());
    case v1::ScalarField::kGrown:
      return grownFrom(message.grown());
    case v1::ScalarField::FAMILY_NOT_SET:
      break;
  }
  return refused("family", "is missing; give fourier, noise, cellular, grain, mapped, layers or grown");
}

void normalise(FieldFamily& family) {
  if (auto* fourier = std::get_if<FourierFamily>(&family)) {
    for (FourierTerm& term : fourier->terms) term.direction = normalised(term.direction);
  }
  if (auto* mapped = std::get_if<MappedFamily>(&family)) {
    mapped->mapping.rotation = normalised(mapped->mapping.rotation);
  }
  if (auto* layered = std::get_if<LayeredFamily>(&family)) {
    for (FieldLayer& layer : layered->layers) normalise(layer.family);
  }
}

void toWire(const FieldFamily& family, v1::ScalarField& message) {
  std::visit([&message](const auto& chosen) { write(chosen, message); }, family);
}

}  // namespace haptics
