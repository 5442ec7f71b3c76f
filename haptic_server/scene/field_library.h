#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <variant>

#include "haptic_server/scene/asset_folders.h"
#include "haptic_server/scene/asset_resolver.h"

namespace haptics {

/// Sampled fields from images below the asset folders, from recipes and from the store; point fields; vertex values. Any
/// number of threads.
class FieldLibrary {
 public:
  /// Both outlive the library.
  FieldLibrary(const AssetFolders& folders, AssetStore& store) : folders_(folders), store_(store) {}

  /// Reading or computing a field takes up to seconds; it is done once while someone holds it. What takes long is done in
  /// a process of its own, and ends when this thread's work is interrupted.
  /// Refused: a file that is not below an asset folder or no image, a hash that is not here.
  [[nodiscard]] Result<Resolved<FieldAsset>> resolve(const FieldSource& source);
  /// A pattern grown on the mesh. Refused: one that cannot grow on it, a hash that is not here.
  [[nodiscard]] Result<Resolved<PointFieldAsset>> resolve(const PointFieldSource& source, const MeshAsset& mesh);
  /// Refused: a file that is not below an asset folder or holds something else, a hash that is not here.
  [[nodiscard]] Result<Resolved<VertexValuesAsset>> resolve(const VertexValuesSource& source);
  [[nodiscard]] Result<Resolved<MovedVerticesAsset>> resolve(const ResidueSource& source) const;

 private:
  /// Canonical path, modification time, size in bytes: the same image.
  using ImageKey = std::tuple<std::string, std::filesystem::file_time_type, std::uintmax_t>;
  using Key = std::variant<ImageKey, ReactionDiffusionSource, SpotNoiseSource>;

  const AssetFolders& folders_;
  AssetStore& store_;
  using GrownKey = std::pair<GrownReactionDiffusionSource, ContentHash>;  ///< A recipe, and the mesh that it is of.
  template <class K, class Kind>
  using Made = std::map<K, std::weak_ptr<const Kind>>;
  std::mutex mutex_;  // guards the two below
  Made<Key, FieldAsset> made_;
  Made<GrownKey, PointFieldAsset> grown_;

  template <class Kind>
  Result<std::shared_ptr<const Kind>> fromAssetFile(const FileSource& file) const;
  Result<Resolved<FieldAsset>> from(const FileSource& file);
  Result<Resolved<FieldAsset>> from(const AssetSource& source) const;
  Result<Resolved<FieldAsset>> from(const ReactionDiffusionSource& recipe);
  Result<Resolved<FieldAsset>> from(const SpotNoiseSource& recipe);
  /// Canonical bytes from a process that may have been taken over by what it read.
  template <class Kind>
  Result<std::shared_ptr<const Kind>> fromImporterProcess(Result<std::string> bytes) const;
  template <class K, class Kind, class Make>
  Result<std::shared_ptr<const Kind>> once(Made<K, Kind>& made, const K& key, Make make);
};

}  // namespace haptics
