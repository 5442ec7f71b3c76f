#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "haptic_server/scene/asset_resolver.h"
#include "haptic_server/scene/sequencer.h"

namespace haptics {

/// The long work of one edit: done on a worker's thread with the scene as it was then, and kept for the commit on the
/// sequencer's thread, which decides the edit by the scene as it is by then. A resolver that does work of milliseconds alone;
/// longer work was prepared, or is refused and the edit has to be prepared (again).
class Preparation final : public AssetResolver {
 public:
  /// Triangles that may be gone through for an edit while others wait; to build a mesh of so many takes 10 ms.
  static constexpr std::size_t kMaxTriangles = 20'000;

  /// The library, which is asked by several threads, outlives the preparation.
  explicit Preparation(AssetResolver& library, std::size_t maxTriangles = kMaxTriangles)
      : library_(library), maxTriangles_(maxTriangles) {}

  /// Tries the edit on this scene and keeps what was made for it, and what could not be made. Any one thread; may be
  /// interrupted. The transaction stays where it is until it is decided.
  void prepare(const Sequencer::Scene& scene, const Transaction& transaction);
  /// From now on everything is made where it is asked for.
  void allowLongWork() noexcept { mayTakeLong_ = true; }

  [[nodiscard]] Result<Resolved<MeshAsset>> resolve(const MeshSource& source, double stiffness_N_per_m) override;
  [[nodiscard]] Result<Resolved<FieldAsset>> resolve(const FieldSource& source) override;
  [[nodiscard]] Result<Resolved<PointFieldAsset>> resolve(const PointFieldSource& source,
                                                          const MeshAsset& mesh) override;
  [[nodiscard]] Result<Resolved<VertexValuesAsset>> resolve(const VertexValuesSource& source) override;
  [[nodiscard]] Result<Resolved<MovedVerticesAsset>> resolve(const ResidueSource& source) override;
  [[nodiscard]] std::vector<std::string> warnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                  const EffectZones& effects) const override {
    return library_.warnings(record, assets, effects);
  }
  [[nodiscard]] Result<void> beforeWork(std::size_t triangles) override;
  [[nodiscard]] bool needsPreparation() const override { return needsPreparation_; }
  [[nodiscard]] const PreparedObject* prepared(const std::string& name) const override;

  /// All that was made, held until the edit is decided.
  [[nodiscard]] std::vector<std::shared_ptr<const Asset>> made() const;

 private:
  static constexpr double kMany = std::numeric_limits<double>::infinity();
  /// Key: where the transaction names the asset, and the mesh that it is of.
  using Place = std::pair<const void*, ContentHash>;
  /// Key: where the transaction names the mesh, and the stiffness of its object.
  using MeshPlace = std::pair<const void*, double>;
  template <class Key, class Kind>
  using Kept = std::map<Key, Result<Resolved<Kind>>>;

  AssetResolver& library_;
  const std::size_t maxTriangles_;
  bool mayTakeLong_ = false;
  bool needsPreparation_ = false;
  double gone_ = 0;  // triangles, while others wait
  Kept<MeshPlace, MeshAsset> meshes_;
  Kept<Place, FieldAsset> fields_;
  Kept<Place, PointFieldAsset> points_;
  Kept<Place, VertexValuesAsset> values_;
  Kept<Place, MovedVerticesAsset> residues_;
  std::vector<PreparedObject> objects_;

  [[nodiscard]] tl::unexpected<Error> refuseLongWork();
  [[nodiscard]] bool mayGoThrough(double triangles);
  template <class Key, class Kind, class Make>
  Result<Resolved<Kind>> once(Kept<Key, Kind>& kept, Key place, Make make, double triangles = kMany);
};

}  // namespace haptics
