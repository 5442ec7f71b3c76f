#include "graphics_client/application/texture_families.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <variant>

#include "common/wire/convert_properties.h"

namespace haptics {
namespace {

constexpr double kUsualAmplitude_m = 3e-4;
/// Of an image.
constexpr double kUsualTile_m = 0.04;

const TextureFamily kFamilies[] = {
    {"waves", "A grating: one wave along x", "fourier { terms { direction { x: 1 } wavelength_m: 0.006 } }"},
    {"weave", "Waves along x, y and z",
     "fourier { terms { direction { x: 1 } wavelength_m: 0.006 } terms { direction { y: 1 } wavelength_m: 0.006 } "
     "terms { direction { z: 1 } wavelength_m: 0.006 } }"},
    {"noise", "Gradient noise (Perlin)", "noise { wavelength_m: 0.008 }"},
    {"rock", "Gradient noise, each octave half as long as the one before", "noise { wavelength_m: 0.016 octaves: 5 }"},
    {"cells", "Distance to the nearest of random points (Worley)", "cellular { cell_m: 0.008 }"},
    {"sandpaper", "Random grains", "grain { grain_m: 0.002 }"},
    {"spots", "Two substances react and diffuse (Turk); mapped from a box around the object",
     "mapped { reaction_diffusion { cells: 6 resolution: 128 } mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.04 } }"},
    {"stripes", "As spots, with another reaction; mapped from a box around the object",
     "mapped { reaction_diffusion { pattern: REACTION_DIFFUSION_PATTERN_STRIPES cells: 6 resolution: 128 } "
     "mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.04 } }"},
    {"fibres", "Spot noise of long spots; mapped from a box around the object",
     "mapped { spot_noise { cells: 12 elongation: 6 resolution: 128 } "
     "mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.04 } }"},
    {"grown spots", "Grown on the mesh itself: no seams, nothing stretched",
     "grown { reaction_diffusion { wavelength_m: 0.008 } }"},
    {"grown stripes", "Grown on the mesh itself: no seams, nothing stretched",
     "grown { reaction_diffusion { pattern: REACTION_DIFFUSION_PATTERN_STRIPES wavelength_m: 0.008 } }"},
    {"rough waves", "Layers: a grating with noise on it",
     "layers { layer { field { fourier { terms { direction { x: 1 } wavelength_m: 0.012 } } } } "
     "layer { weight: 0.5 field { noise { wavelength_m: 0.004 } } } }"},
};

bool isTold(const FieldFamily& family) {
  return !std::holds_alternative<MappedFamily>(family) && !std::holds_alternative<GrownFamily>(family) &&
         !std::holds_alternative<LayeredFamily>(family);
}

/// Of one alternative: whether a user would call both by one name.
bool areAlike(const FieldFamily& a, const FieldFamily& b) {
  if (a.index() != b.index()) return false;
  if (const auto* fourier = std::get_if<FourierFamily>(&a)) {
    return fourier->terms.size() == std::get<FourierFamily>(b).terms.size();
  }
  if (const auto* noise = std::get_if<NoiseFamily>(&a)) {
    return (noise->octaves > 1) == (std::get<NoiseFamily>(b).octaves > 1);
  }
  return true;
}

/// The largest.
struct Size {
  using Length = std::optional<double>;

  Length operator()(const FourierFamily& family) const {
    return std::ranges::max_element(family.terms, {}, &FourierTerm::wavelength_m)->wavelength_m;
  }
  Length operator()(const NoiseFamily& family) const { return family.wavelength_m; }
  Length operator()(const CellularFamily& family) const { return family.cell_m; }
  Length operator()(const GrainFamily& family) const { return family.grain_m; }
  Length operator()(const MappedFamily& family) const { return family.mapping.tile_m; }
  Length operator()(const GrownFamily& /*family*/) const { return {}; }
  Length operator()(const LayeredFamily& family) const {
    Length largest = 0;
    for (const FieldLayer& layer : family.layers) {
      const Length length = std::visit(*this, layer.family);
      if (!length) return {};
      largest = std::max(*largest, *length);
    }
    return largest;
  }
};

struct Scale {
  double factor;

  void operator()(FourierFamily& family) const {
    for (FourierTerm& term : family.terms) term.wavelength_m *= factor;
  }
  void operator()(NoiseFamily& family) const { family.wavelength_m *= factor; }
  void operator()(CellularFamily& family) const { family.cell_m *= factor; }
  void operator()(GrainFamily& family) const { family.grain_m *= factor; }
  void operator()(MappedFamily& family) const { family.mapping.tile_m *= factor; }
  void operator()(GrownFamily& /*family*/) const {}
  void operator()(LayeredFamily& family) const {
    for (FieldLayer& layer : family.layers) std::visit(*this, layer.family);
  }
};

}  // namespace

v1::ScalarField TextureFamily::make() const {
  v1::ScalarField message;
  google::protobuf::TextFormat::ParseFromString(field, &message);
  return message;
}

std::span<const TextureFamily> textureFamilies() { return kFamilies; }

std::optional<std::size_t> textureFamilyOf(const FieldFamily& family) {
  if (!isTold(family)) return {};
  for (std::size_t i = 0; i < std::size(kFamilies); ++i) {
    if (const auto offered = fieldFrom(kFamilies[i].make()); offered && areAlike(family, offered->family)) return i;
  }
  return {};
}

std::optional<double> textureSize_m(const FieldFamily& family) { return std::visit(Size{}, family); }

void setTextureSize_m(FieldFamily& family, double size_m) {
  if (const auto present = textureSize_m(family)) std::visit(Scale{size_m / *present}, family);
}

v1::ScalarField imageField(const ContentHash& field) {
  v1::ScalarField message;
  v1::MappedField& mapped = *message.mutable_mapped();
  mapped.set_asset(field.asBytes());
  mapped.mutable_mapping()->set_shape(v1::MAPPING_SHAPE_CUBE);
  mapped.mutable_mapping()->set_tile_m(kUsualTile_m);
  return message;
}

v1::Texture textureOf(const SurfaceProperties& surface) {
  v1::ObjectState state;
  toWire(surface, state);
  if (!state.has_texture()) state.mutable_texture()->set_amplitude_m(kUsualAmplitude_m);
  return state.texture();
}

}  // namespace haptics
