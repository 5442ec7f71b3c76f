#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/import.h"
#include "common/scene/asset_source.h"
#include "graphics_client/editing/named_assets.h"
#include "haptics/v1/envelope.pb.h"
#include "haptics/v1/scene.pb.h"

// Assets made from files of this machine, to be uploaded to a server.
namespace haptics {

/// Canonical bytes, and what an edit names them by.
struct LocalAsset {
  AssetKind kind = AssetKind::kMesh;
  std::string bytes;
  ContentHash hash;
};
[[nodiscard]] LocalAsset localAsset(AssetKind kind, std::string bytes);

struct LocalMesh {
  LocalAsset asset;
  MeshReport report;
};

/// importMeshFile() of a file of the user's own: takes up to minutes, ends soon after `stop` asks for it.
[[nodiscard]] Result<LocalMesh> readMeshFile(const std::filesystem::path& file, const ImportOptions& options,
                                             const std::stop_token& stop = {});
/// The same of a file whose unit neither its sender nor itself says (a .mesh file is in metres): as likelyScale() has it.
[[nodiscard]] Result<LocalMesh> readMeshFileOfAnyUnit(const std::filesystem::path& file, const std::stop_token& stop);

/// What a scene names by a file, with its options there.
struct LocalFile {
  LocalAsset asset;
  std::string report;  ///< What its reading kept and dropped, one line.
};
/// Takes up to minutes. Errors name the file.
[[nodiscard]] Result<LocalFile> readNamedFile(const AssetReference& reference, const std::filesystem::path& file);

/// What became of the upload of a file's asset. Errors name the file.
[[nodiscard]] Result<void> outcomeOf(const v1::AssetUploadReply& reply, const std::filesystem::path& file);

/// A name that an object may have, from that of a file: other characters become "_".
[[nodiscard]] std::string objectNameOf(const std::filesystem::path& file);

}  // namespace haptics
