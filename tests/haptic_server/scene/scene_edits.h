#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/scene/asset_resolver.h"
#include "haptic_server/scene/sequencer.h"

namespace haptics::test {

inline MeshSource box(double side_m = 0.1) { return {BoxSource{Vec3(side_m), 1}}; }
inline MeshSource file(std::string path) { return {FileSource{std::move(path)}}; }
/// "o7". (As a sum of strings it makes g++ 12 warn of overlapping memory, PR 105651.)
inline std::string numbered(std::string prefix, std::uint64_t number) { return prefix.append(std::to_string(number)); }
inline ObjectRef named(std::string name) { return {std::move(name)}; }
inline Operation add(std::string name, MeshSource mesh = box()) {
  return AddObject{std::move(name), std::move(mesh), {}, {}};
}
inline Operation moveTo(std::string name, Vec3 position) { return SetPose{named(std::move(name)), {position, {}}}; }
inline Operation remove(std::string name) { return RemoveObject{named(std::move(name))}; }
inline Operation setSurface(SurfaceEdit surface, std::string name = "a") {
  MaterialEdit material;
  material.surface = std::move(surface);
  return SetMaterial{named(std::move(name)), std::move(material)};
}

/// Of each of so many vertices.
inline VertexValuesSource sameValues(float value, std::size_t count = 8) {
  return {GivenValues{std::vector<float>(count, value)}};
}
inline MappedSource spots(std::uint32_t seed) { return {SpotNoiseSource{.seed = seed}, true, true}; }
/// A texture of spots, and friction by the vertices of a box.
inline SurfaceEdit spottedSurface() {
  SurfaceEdit surface;
  surface.texture = TextureEdit{Texture{.family = MappedFamily{{}, {.tile_m = 0.01}}, .amplitude_m = 1e-3}, {spots(5)}};
  surface.friction = FrictionEdit{Friction{0.6, 0.3, 0, PerVertexScale{}}, sameValues(0.5F)};
  return surface;
}

template <class... Operations>
Transaction edit(Operations... operations) {
  return {{}, {std::move(operations)...}};
}

using Accepted = std::shared_ptr<const AcceptedEdit>;

/// Boxes of the asked size, small fields by their seed, what grows on a mesh at its vertices, and what the store holds; a file is refused, as by a server
/// without any.
class BoxResolver final : public AssetResolver {
 public:
  Result<Resolved<MeshAsset>> resolve(const MeshSource& source, double) override {
    ++resolved;
    if (const auto* asset = std::get_if<AssetSource>(&source.source)) return found<MeshAsset>(asset->hash);
    const auto* box = std::get_if<BoxSource>(&source.source);
    if (!box) return refused("file", "is not here");
    return Resolved<MeshAsset>{store_.intern(makeBox(box->size_m, box->segments).value()), "made"};
  }
  Result<Resolved<FieldAsset>> resolve(const FieldSource& source) override {
    ++resolved;
    if (const auto* spots = std::get_if<SpotNoiseSource>(&source)) {
      return Resolved<FieldAsset>{store_.intern(smallField(static_cast<float>(spots->seed))), "computed"};
    }
    const auto* asset = std::get_if<AssetSource>(&source);
    if (!asset) return refused("image", "is not here");
    return found<FieldAsset>(asset->hash);
  }
  Result<Resolved<PointFieldAsset>> resolve(const PointFieldSource& source, const MeshAsset& mesh) override {
    ++resolved;
    if (const auto* asset = std::get_if<AssetSource>(&source)) return found<PointFieldAsset>(asset->hash);
    const auto& recipe = std::get<GrownReactionDiffusionSource>(source);
    if (recipe.wavelength_m < 1e-3) return refused("reaction_diffusion.wavelength_m", "is too short");
    auto points = grownOn(*mesh.mesh, recipe.seed);
    if (!points) return refused("reaction_diffusion", points.error().text());
    return Resolved<PointFieldAsset>{store_.intern(*std::move(points)), "grown"};
  }
  Result<Resolved<VertexValuesAsset>> resolve(const VertexValuesSource& source) override {
    ++resolved;
    const auto* given = std::get_if<GivenValues>(&source);
    if (!given) return found<VertexValuesAsset>(std::get<AssetSource>(source).hash);
    return Resolved<VertexValuesAsset>{store_.intern(given->values), "taken"};
  }
  Result<Resolved<MovedVerticesAsset>> resolve(const ResidueSource& source) override {
    ++resolved;
    return found<MovedVerticesAsset>(std::get<AssetSource>(source).hash);
  }
  [[nodiscard]] static SampledField smallField(float value) {
    return SampledField::make(2, 2, {0, value / 2, value, value / 4}).value();
  }
  [[nodiscard]] static Result<PointField> grownOn(const TriMesh& mesh, std::uint32_t seed) {
    std::vector<PointSample> samples;
    for (const Vec3f vertex : mesh.vertices) samples.push_back({vertex, static_cast<float>(seed)});
    return PointField::make(0.5F, std::move(samples));
  }
  [[nodiscard]] const AssetStore& store() const { return store_; }
  [[nodiscard]] AssetStore& store() { return store_; }
  int resolved = 0;

 private:
  AssetStore store_;

  template <class Kind>
  Result<Resolved<Kind>> found(const ContentHash& hash) const {
    auto asset = as<Kind>(store_.find(hash));
    if (!asset) return refused("asset", "is not here");
    return Resolved<Kind>{std::move(asset), "held"};
  }
};

}  // namespace haptics::test
