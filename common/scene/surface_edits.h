#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/scene/asset_source.h"
#include "common/scene/surface_properties.h"

// Surface properties as an edit asks for them.
namespace haptics {

/// Samples along a tile's side of a computed field, unless an edit says otherwise.
inline constexpr std::uint32_t kDefaultResolution = 256;

struct ReactionDiffusionSource {
  enum class Pattern : std::uint8_t { kSpots = 1, kStripes };
  Pattern pattern = Pattern::kSpots;
  std::uint32_t cells = 12;  ///< Spots or stripes along a tile's side.
  std::uint32_t resolution = kDefaultResolution;
  std::uint32_t seed = 1;
  auto operator<=>(const ReactionDiffusionSource&) const = default;
};

struct SpotNoiseSource {
  std::uint32_t cells = 12;  ///< Spots' widths along a tile's side.
  double elongation = 1;     ///< Of a spot along x, over its width.
  std::uint32_t resolution = kDefaultResolution;
  std::uint32_t seed = 1;
  auto operator<=>(const SpotNoiseSource&) const = default;
};

/// A pattern that grows on the object's mesh.
struct GrownReactionDiffusionSource {
  ReactionDiffusionSource::Pattern pattern = ReactionDiffusionSource::Pattern::kSpots;
  double wavelength_m = 0;  ///< From spot to spot or stripe to stripe along the surface.
  std::uint32_t seed = 1;
  auto operator<=>(const GrownReactionDiffusionSource&) const = default;
};

/// Source of a mapped family's field. A file is an image, or holds a field's canonical bytes.
using FieldSource = std::variant<FileSource, AssetSource, ReactionDiffusionSource, SpotNoiseSource>;
/// Source of a grown family's field.
using PointFieldSource = std::variant<AssetSource, GrownReactionDiffusionSource, FileSource>;

struct GivenValues {
  std::vector<float> values;
};
using VertexValuesSource = std::variant<AssetSource, GivenValues, FileSource>;

/// What of a mapped family an edit leaves to be made.
struct MappedSource {
  FieldSource field;
  bool centreOfMesh = false, sizeOfMesh = false;    ///< Of the mesh's box in the mapping's frame.
  std::optional<std::size_t> layer = std::nullopt;  ///< Whose family it is, of a layered one.
};
/// The same of a grown family.
struct GrownSource {
  PointFieldSource points;
  std::optional<std::size_t> layer = std::nullopt;
};
using FamilySource = std::variant<MappedSource, GrownSource>;
/// Where its family is below ScalarField: "mapped", "layers.layer[1].field.grown".
[[nodiscard]] std::string fieldName(const FamilySource& source);
[[nodiscard]] std::optional<std::size_t> layerOf(const FamilySource& source);
/// As a map needs it: of each mapped or grown family, or of per-vertex values.
struct FactorMapSource : std::variant<std::vector<FamilySource>, VertexValuesSource> {
  using variant::variant;
  using variant::operator=;
  FactorMapSource() noexcept;
  FactorMapSource(const FactorMapSource&);
  FactorMapSource(FactorMapSource&&) noexcept;
  FactorMapSource& operator=(const FactorMapSource&);
  FactorMapSource& operator=(FactorMapSource&&) noexcept;
  ~FactorMapSource();
};

/// In the three below, the hash of a field or of per-vertex values is zero until its source has been resolved.
struct FrictionEdit {
  Friction friction;
  FactorMapSource source = {}, dynamicSource = {};  ///< Of friction.over and friction.dynamicOver.
};
struct TextureEdit {
  Texture texture;
  std::vector<FamilySource> sources;  ///< Of each mapped or grown family.
};

struct SurfaceMapEdit {
  SurfaceMap map;
  FactorMapSource source = {};
};

/// Each property is kept where nothing is said of it, and taken away where it is given as nothing.
struct SurfaceEdit {
  std::optional<std::optional<Shading>> shading;
  std::optional<std::optional<FrictionEdit>> friction;
  std::optional<std::optional<TextureEdit>> texture;
  std::optional<std::optional<SurfaceMapEdit>> stiffnessOver, softnessOver;
  SurfaceScalars<std::optional<double>> scalars = {};

  [[nodiscard]] bool empty() const noexcept {
    return !shading && !friction && !texture && !stiffnessOver && !softnessOver &&
           scalars == SurfaceScalars<std::optional<double>>{};
  }
};

[[nodiscard]] SurfaceProperties edited(SurfaceProperties properties, const SurfaceEdit& edit);

}  // namespace haptics
