#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include "haptic_server/scene/asset_folders.h"
#include "haptic_server/scene/asset_resolver.h"

namespace haptics {

using ResolvedMesh = Resolved<MeshAsset>;

/// Meshes from files below the asset folders, from generators and from the store. One thread.
class MeshLibrary {
 public:
  /// Both outlive the library.
  MeshLibrary(const AssetFolders& folders, AssetStore& store) : folders_(folders), store_(store) {}

  /// What takes long is done in a process of its own, and ends when this thread's work is interrupted. Refused: a file that
  /// is not below an asset folder, and whatever importMeshFile() and the generators refuse. Errors name a file as the
  /// source does, never where it lies.
  [[nodiscard]] Result<ResolvedMesh> resolve(const MeshSource& source);

 private:
  /// Canonical path, modification time, size in bytes, unit_m, largestExtent_m, keepCrossings: the same mesh comes out.
  using FileKey =
      std::tuple<std::string, std::filesystem::file_time_type, std::uintmax_t, double, std::optional<double>, bool>;
  struct Imported {
    std::weak_ptr<const MeshAsset> asset;
    std::string report;
  };

  const AssetFolders& folders_;
  AssetStore& store_;
  std::map<FileKey, Imported> imported_;

  Result<ResolvedMesh> fromFile(const MeshSource& source, const FileSource& file);
  Result<ResolvedMesh> fromStore(const AssetSource& asset) const;
  Result<ResolvedMesh> generated(const MeshSource& source);
  /// Canonical bytes from a process that may have been taken over by what it read.
  Result<std::shared_ptr<const MeshAsset>> fromElsewhere(std::string bytes);
};

}  // namespace haptics
