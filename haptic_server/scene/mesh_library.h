#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "haptic_server/scene/mesh_resolver.h"

namespace haptics {

/// Meshes from files below the asset folders, from generators and from the store. One thread.
class MeshLibrary final : public MeshResolver {
 public:
  /// Files are looked for in the folders in this order.
  MeshLibrary(std::vector<std::filesystem::path> folders, AssetStore& store);

  /// Refused: a file that is not below an asset folder once `..` and symbolic links are followed, and whatever
  /// importMesh and the generators refuse. Errors name a file as the source does, never where it lies.
  [[nodiscard]] Result<ResolvedMesh> resolve(const MeshSource& source) override;

 private:
  /// Canonical path, modification time, size in bytes, unit_m, largestExtent_m: the same mesh comes out.
  using FileKey =
      std::tuple<std::string, std::filesystem::file_time_type, std::uintmax_t, double, std::optional<double>>;
  struct Imported {
    std::weak_ptr<const MeshAsset> asset;
    std::string report;
  };

  std::vector<std::filesystem::path> folders_;
  AssetStore& store_;
  std::map<FileKey, Imported> imported_;

  Result<std::filesystem::path> locate(const std::string& path) const;
  Result<ResolvedMesh> fromFile(const MeshSource& source, const FileSource& file);
  Result<ResolvedMesh> fromStore(const AssetSource& asset) const;
  Result<ResolvedMesh> generated(const MeshSource& source);
};

}  // namespace haptics
