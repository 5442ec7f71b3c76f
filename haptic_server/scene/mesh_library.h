#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "common/importer/mesh_recipe.h"
#include "common/mesh/file_bytes.h"
#include "haptic_server/scene/asset_folders.h"
#include "haptic_server/scene/asset_resolver.h"

namespace haptics {

using ResolvedMesh = Resolved<MeshAsset>;

/// Input of a generator; none of a file or an asset.
[[nodiscard]] std::optional<MeshRecipe> recipeOf(const MeshSource& source);
/// Triangles that are made for such a source; infinite for a file, of which that is not known.
[[nodiscard]] double trianglesMadeFor(const MeshSource& source);

/// Meshes from files below the asset folders, from generators and from the store. Any number of threads.
class MeshLibrary {
 public:
  /// Both outlive the library.
  MeshLibrary(const AssetFolders& folders, AssetStore& store) : folders_(folders), store_(store) {}

  /// Files are read and large meshes made in a process of its own; a mesh that is to be simplified is, in this
  /// thread. Either ends when this thread's work is interrupted. Refused: a file that is not below an asset folder, and
  /// whatever importMeshFile() and the generators refuse. Errors name a file as the source does, never where it lies.
  /// @param stiffness_N_per_m  With which a mesh that is to be simplified is judged.
  [[nodiscard]] Result<ResolvedMesh> resolve(const MeshSource& source, double stiffness_N_per_m);

 private:
  /// The file, unit_m, largestExtent_m, keepCrossings, part: the same mesh comes out while the files that it includes stay.
  using FileKey = std::tuple<FileStamp, std::optional<double>, std::optional<double>, bool, PartName>;
  struct Imported {
    std::weak_ptr<const MeshAsset> asset;
    std::string report;
    std::vector<FileStamp> included;
  };
  struct FromFile {
    ResolvedMesh mesh;
    std::vector<FileStamp> included = {};
  };
  /// A file, simplifyError and the stiffness.
  using SimplifiedKey = std::tuple<FileKey, double, double>;

  const AssetFolders& folders_;
  AssetStore& store_;
  std::mutex mutex_;  // guards the two below
  std::map<FileKey, Imported> imported_;
  std::map<SimplifiedKey, Imported> simplified_;

  template <class Key>
  std::optional<FromFile> known(const std::map<Key, Imported>& meshes, const Key& key);
  template <class Key>
  void keep(std::map<Key, Imported>& meshes, const Key& key, const FromFile& made);

  Result<FromFile> unsimplified(const MeshSource& source);
  Result<ResolvedMesh> simplified(const MeshSource& source, double stiffness_N_per_m);
  [[nodiscard]] Result<FileKey> keyOf(const MeshSource& source, const FileSource& file) const;
  Result<FromFile> fromFile(const MeshSource& source, const FileSource& file);
  Result<ResolvedMesh> fromStore(const AssetSource& asset) const;
  Result<ResolvedMesh> generated(const MeshSource& source);
  /// Canonical bytes from a process that may have been taken over by what it read.
  Result<std::shared_ptr<const MeshAsset>> fromImporterProcess(std::string bytes);
};

}  // namespace haptics
