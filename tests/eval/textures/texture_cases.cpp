#include "tests/eval/textures/texture_cases.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/surface/field_asset.h"
#include "common/surface/make_field.h"
#include "common/surface/makers/image_field.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/makers/spot_noise.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

constexpr double kTile_m = 0.024;
constexpr double kObject_m = 0.06;  // of what the wrapped ones are wrapped round

TextureCase textureCase(std::string name, std::string title, FieldFamily family,
                        std::shared_ptr<const SampledField> sampled = nullptr) {
  TextureCase made{std::move(name), std::move(title), std::move(family), std::move(sampled), nullptr, nullptr, 0};
  made.field = orThrow(makeField(made.family, [&](const ContentHash&) { return made.sampled; }));
  const auto* mapped = std::get_if<MappedFamily>(&made.family);
  if (!mapped || mapped->mapping.shape == Mapping::Shape::kPlane) {
    made.reference = referenceOf(made.family, made.sampled);
  }
  return made;
}

TextureCase mapped(std::string name, std::string title, SampledField field, double turn_rad = 0) {
  auto sampled = std::make_shared<const SampledField>(std::move(field));
  Mapping mapping;
  mapping.tile_m = kTile_m;
  mapping.rotation = glm::angleAxis(turn_rad, Vec3(0, 0, 1));
  const MappedFamily family{hashOf(*sampled), mapping};
  return textureCase(std::move(name), std::move(title), family, std::move(sampled));
}

/// A wall of bricks, kExhibitCells to a row, two rows as high as one is wide, as a PNG file.
std::string brickImage() {
  constexpr std::uint32_t kSide = 256;
  constexpr std::uint32_t kBrick = kSide / kExhibitCells;
  constexpr double kJoint = 7;  // pixels from a brick's border to its top
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t row = y / (kBrick / 2);
      const double across = (x + row % 2 * (kBrick / 2)) % kBrick + 0.5;
      const double up = y % (kBrick / 2) + 0.5;
      const double inside = std::min({across, kBrick - across, up, kBrick / 2.0 - up}) / kJoint;
      const double t = std::min(1.0, inside);
      pixels.push_back(static_cast<std::uint8_t>(std::lround(255 * t * t * (3 - 2 * t))));
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = kSide;
  image.format = PNG_FORMAT_GRAY;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string file(size, '\0');
  if (!png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), 0, nullptr)) {
    throw std::runtime_error(std::string("libpng: ") + image.message);
  }
  file.resize(size);
  return file;
}

}  // namespace

std::shared_ptr<const ScalarField> makeFieldOf(const FieldFamily& family) {
  return orThrow(makeField(family, [](const ContentHash&) { return nullptr; }));
}

TextureCase makeGrating(double wavelength_m) {
  TextureCase grating = textureCase("fourier_grating", "Fourier: one wave",
                                    FourierFamily{{FourierTerm{1, Vec3(1, 0, 0), wavelength_m, 0.4}}});
  grating.wavelength_m = wavelength_m;
  return grating;
}

std::vector<TextureCase> makeTextureCases(std::uint32_t seed) {
  using Pattern = ReactionDiffusionSource::Pattern;
  std::vector<TextureCase> all;
  all.push_back(makeGrating(2e-3));
  all.push_back(
      textureCase("fourier_sum", "Fourier: three waves",
                  FourierFamily{{FourierTerm{1, Vec3(1, 0, 0), 3e-3, 0}, FourierTerm{0.6, Vec3(0.6, 0.8, 0), 5e-3, 1},
                                 FourierTerm{0.4, Vec3(-0.28, 0.96, 0), 2e-3, 2}}}));
  all.back().wavelength_m = 3e-3;
  all.push_back(textureCase("noise", "Gradient noise", NoiseFamily{3e-3, 1, 0.5, seed}));
  all.push_back(textureCase("fractal", "Fractal noise", NoiseFamily{8e-3, 4, 0.5, seed}));
  all.push_back(textureCase("cellular", "Cellular", CellularFamily{4e-3, 0.1, seed}));
  all.push_back(textureCase("grain", "Sandpaper", GrainFamily{1.5e-3, seed}));
  all.push_back(mapped("spots", "Reaction\u2013diffusion: spots",
                       reactionDiffusion({Pattern::kSpots, kExhibitCells, kDefaultResolution, seed})));
  all.push_back(mapped("stripes", "Reaction\u2013diffusion: stripes",
                       reactionDiffusion({Pattern::kStripes, kExhibitCells, kDefaultResolution, seed})));
  all.push_back(mapped("spot_noise", "Spot noise",
                       spotNoise({kExhibitCells, kExhibitElongation, kDefaultResolution, seed}), 1.2));
  all.push_back(mapped("image", "Image: bricks", orThrow(fieldFromImage(brickImage()))));
  all.back().wavelength_m = kTile_m / kExhibitCells;
  return all;
}

std::vector<TextureCase> wrapped(const std::vector<TextureCase>& textureCases) {
  using Shape = Mapping::Shape;
  std::vector<TextureCase> all;
  for (const TextureCase& flat : textureCases) {
    const auto* family = std::get_if<MappedFamily>(&flat.family);
    if (!family) continue;
    for (const auto& [shape, name] :
         {std::pair{Shape::kCube, "cube"}, {Shape::kCylinder, "cylinder"}, {Shape::kSphere, "sphere"}}) {
      MappedFamily around = *family;
      around.mapping.shape = shape;
      around.mapping.size_m = Vec3(kObject_m);
      around.mapping.rotation = glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, -1)));
      around.mapping.centre = Vec3(0.003, -0.002, 0.001);
      all.push_back(textureCase(flat.name, flat.title, around, flat.sampled));
      all.back().name += std::string("_on_") + name;
    }
  }
  return all;
}

Texture textureOf(const TextureCase& textureCase, double height_m, double gain_K) {
  Texture texture;
  texture.family = textureCase.family;
  texture.amplitude_m = height_m / (textureCase.field->highest() - textureCase.field->lowest());
  texture.gain_K = gain_K;
  return texture;
}

}  // namespace haptics::eval
