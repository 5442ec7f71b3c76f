#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <variant>

#include "haptic_server/scene/asset_folders.h"
#include "haptic_server/scene/asset_resolver.h"

namespace haptics {

/// Sampled fields from images below the asset folders, from recipes and from the store; vertex values. One thread.
class FieldLibrary {
 public:
  /// Both outlive the library.
  FieldLibrary(const AssetFolders& folders, AssetStore& store) : folders_(folders), store_(store) {}

  /// Reading or computing a field takes up to seconds; it is done once while someone holds it. What takes long is done in
  /// a process of its own, and ends when this thread's work is interrupted.
  /// Refused: a file that is not below an asset folder or no image, a hash that is not here.
  [[nodiscard]] Result<Resolved<FieldAsset>> resolve(const FieldSource& source);
  /// Refused: a hash that is not here.
  [[nodiscard]] Result<Resolved<VertexValuesAsset>> resolve(const VertexValuesSource& source);

 private:
  /// Canonical path, modification time, size in bytes: the same image.
  using ImageKey = std::tuple<std::string, std::filesystem::file_time_type, std::uintmax_t>;
  using Key = std::variant<ImageKey, ReactionDiffusionSource, SpotNoiseSource>;

  const AssetFolders& folders_;
  AssetStore& store_;
  std::map<Key, std::weak_ptr<const FieldAsset>> made_;

  Result<Resolved<FieldAsset>> from(const FileSource& file);
  Result<Resolved<FieldAsset>> from(const AssetSource& source) const;
  Result<Resolved<FieldAsset>> from(const ReactionDiffusionSource& recipe);
  Result<Resolved<FieldAsset>> from(const SpotNoiseSource& recipe);
  /// Canonical bytes from a process that may have been taken over by what it read.
  Result<std::shared_ptr<const FieldAsset>> fromElsewhere(Result<std::string> bytes);
  template <class Make>
  Result<std::shared_ptr<const FieldAsset>> once(const Key& key, Make make);
};

}  // namespace haptics
