#include "graphics_client/application/texture_preview.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <variant>

#include "common/surface/makers/grown_reaction_diffusion.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/makers/spot_noise.h"
#include "common/wire/convert_properties.h"
#include "graphics_client/application/texture_families.h"

namespace haptics {
namespace {

/// Side of the plate that patterns are grown on.
constexpr double kPlate_m = 0.04;
/// Largest slope of the picture's height map: more is harsher.
constexpr double kSteepest = 1.6;
constexpr double kAmbient = 0.15, kDiffuse = 0.85;
const Vec3 kLight = glm::normalize(Vec3(-1, 1, 1.6));

template <class Value>
using Known = std::map<ContentHash, std::shared_ptr<const Value>>;

template <class Value>
std::shared_ptr<const Value> find(const Known<Value>& known, const ContentHash& hash) {
  const auto at = known.find(hash);
  return at == known.end() ? nullptr : at->second;
}

/// A name for what is not hashed.
ContentHash numbered(std::size_t number) { return ContentHash{{static_cast<std::uint8_t>(number + 1)}}; }

TriMesh plate() {
  constexpr auto kHalf_m = static_cast<float>(kPlate_m / 2);
  return {{{-kHalf_m, -kHalf_m, 0}, {kHalf_m, -kHalf_m, 0}, {kHalf_m, kHalf_m, 0}, {-kHalf_m, kHalf_m, 0}},
          {{0, 1, 2}, {0, 2, 3}}};
}

FieldFamily& familyOf(FieldFamily& family, std::optional<std::size_t> layer) {
  return layer ? std::get<LayeredFamily>(family).layers[*layer].family : family;
}

/// On the plane z = 0.
void flatten(FieldFamily& family) {
  if (auto* mapped = std::get_if<MappedFamily>(&family)) mapped->mapping = {.tile_m = mapped->mapping.tile_m};
  if (auto* layered = std::get_if<LayeredFamily>(&family)) {
    for (FieldLayer& layer : layered->layers) flatten(layer.family);
  }
}

/// So that a few waves are seen.
double sideOf_m(const FieldFamily& family) {
  const double size_m = textureSize_m(family).value_or(kPlate_m);
  if (std::holds_alternative<MappedFamily>(family) || std::holds_alternative<GrownFamily>(family)) return size_m;
  constexpr double kWaves = 4, kGrains = 12;
  return (std::holds_alternative<GrainFamily>(family) ? kGrains : kWaves) * size_m;
}

std::vector<std::uint8_t> shaded(const ScalarField& field, double side_m, int side_px) {
  const double pixel_m = side_m / side_px;
  std::vector<glm::dvec2> slopes;
  double steepest = 0;
  for (int row = 0; row < side_px; ++row) {
    for (int column = 0; column < side_px; ++column) {
      const Vec3 point((column + 0.5) * pixel_m - side_m / 2, side_m / 2 - (row + 0.5) * pixel_m, 0);
      const Vec3 gradient = field.at(point).gradient;
      slopes.emplace_back(gradient.x, gradient.y);
      steepest = std::max(steepest, glm::length(slopes.back()));
    }
  }
  const double scale = steepest > 0 ? kSteepest / steepest : 0;
  std::vector<std::uint8_t> shades;
  for (const glm::dvec2& slope : slopes) {
    const Vec3 normal = glm::normalize(Vec3(-scale * slope.x, -scale * slope.y, 1));
    const double light = kAmbient + kDiffuse * std::max(glm::dot(normal, kLight), 0.0);
    shades.push_back(static_cast<std::uint8_t>(std::lround(255 * std::min(light, 1.0))));
  }
  return shades;
}

/// The heights themselves, of one tile: an image as it is. Means over each pixel.
std::vector<std::uint8_t> asImage(const ScalarField& field, double side_m, int side_px) {
  constexpr int kOver = 4;
  const double step_m = side_m / side_px / kOver;
  std::vector<double> heights(static_cast<std::size_t>(side_px) * side_px);
  for (int row = 0; row < kOver * side_px; ++row) {
    for (int column = 0; column < kOver * side_px; ++column) {
      const Vec3 point((column + 0.5) * step_m - side_m / 2, side_m / 2 - (row + 0.5) * step_m, 0);
      heights[static_cast<std::size_t>(row / kOver * side_px + column / kOver)] += field.at(point).value;
    }
  }
  const auto [low, high] = std::ranges::minmax(heights);
  std::vector<std::uint8_t> shades;
  for (const double height : heights) {
    shades.push_back(static_cast<std::uint8_t>(std::lround(high > low ? 255 * (height - low) / (high - low) : 128)));
  }
  return shades;
}

Result<std::vector<std::uint8_t>> previewOf(FieldFamily family, const FieldLookup& lookup,
                                            const PointFieldLookup& pointLookup, int side_px) {
  flatten(family);
  const auto field = makeField(family, lookup, pointLookup);
  if (!field) return tl::unexpected(field.error());
  return shaded(**field, sideOf_m(family), side_px);
}

/// What a source names, computed; null for what lies with the server.
std::shared_ptr<const SampledField> computed(const FieldSource& source) {
  if (const auto* reaction = std::get_if<ReactionDiffusionSource>(&source)) {
    return std::make_shared<const SampledField>(reactionDiffusion(*reaction));
  }
  if (const auto* spots = std::get_if<SpotNoiseSource>(&source)) {
    return std::make_shared<const SampledField>(spotNoise(*spots));
  }
  return nullptr;
}

}  // namespace

Result<std::vector<std::uint8_t>> texturePreview(const v1::ScalarField& field, int side_px) {
  auto edit = fieldFrom(field);
  if (!edit) return tl::unexpected(std::move(edit).error());
  Known<SampledField> fields;
  Known<PointField> pointFields;
  for (std::size_t i = 0; i < edit->sources.size(); ++i) {
    FieldFamily& family = familyOf(edit->family, layerOf(edit->sources[i]));
    if (const auto* mapped = std::get_if<MappedSource>(&edit->sources[i])) {
      std::get<MappedFamily>(family).field = numbered(i);
      if (auto made = computed(mapped->field)) fields[numbered(i)] = std::move(made);
    } else if (const auto* grown =
                   std::get_if<GrownReactionDiffusionSource>(&std::get<GrownSource>(edit->sources[i]).points)) {
      auto points = grownReactionDiffusion(plate(), *grown);
      if (!points) return tl::unexpected(std::move(points).error());
      std::get<GrownFamily>(family).points = numbered(i);
      pointFields[numbered(i)] = std::make_shared<const PointField>(*std::move(points));
    }
  }
  return previewOf(
      std::move(edit->family), [&](const ContentHash& hash) { return find(fields, hash); },
      [&](const ContentHash& hash) { return find(pointFields, hash); }, side_px);
}

Result<std::vector<std::uint8_t>> texturePreview(const FieldFamily& family, const FieldLookup& lookup, int side_px) {
  if (!std::holds_alternative<MappedFamily>(family)) return previewOf(family, lookup, {}, side_px);
  FieldFamily flat = family;
  flatten(flat);
  const auto field = makeField(flat, lookup, {});
  if (!field) return tl::unexpected(field.error());
  return asImage(**field, sideOf_m(flat), side_px);
}

}  // namespace haptics
