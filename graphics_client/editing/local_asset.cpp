#include "graphics_client/editing/local_asset.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "common/assets/asset_content.h"
#include "common/importer/importer.h"
#include "common/mesh/file_bytes.h"

namespace haptics {
namespace {

/// Of an object's name, less what is put behind it where it is taken.
constexpr std::size_t kLongestName = 58;

/// The unit or extent, and what else a scene says of the mesh's file.
ImportOptions importOptionsOf(const v1::MeshSource& source) {
  ImportOptions options;
  if (source.has_unit_m()) options.unit_m = source.unit_m();
  if (source.has_largest_extent_m()) options.largestExtent_m = source.largest_extent_m();
  options.keepCrossings = source.keep_crossings();
  options.part = PartName(source.part());
  return options;
}

}  // namespace

LocalAsset localAsset(AssetKind kind, std::string bytes) {
  const ContentHash hash = Hasher().add(std::as_bytes(std::span(bytes))).finish();
  return {kind, std::move(bytes), hash};
}

Result<LocalMesh> readMeshFile(const std::filesystem::path& file, const ImportOptions& options,
                               const std::stop_token& stop) {
  auto imported = importMeshFile(file, file.parent_path(), options, stop);
  if (!imported) return tl::unexpected(std::move(imported).error());
  return LocalMesh{localAsset(AssetKind::kMesh, std::move(imported->bytes)), imported->report};
}

Result<LocalMesh> readMeshFileOfAnyUnit(const std::filesystem::path& file, const std::stop_token& stop) {
  auto inMetres = readMeshFile(file, {}, stop);
  if (!inMetres) return inMetres;
  const bool isKnown = inMetres->report.isUnitKnown;
  const auto scale = isKnown ? std::nullopt : likelyScale(inMetres->report.longestSide_m());
  return scale ? readMeshFile(file, *scale, stop) : inMetres;
}

Result<LocalFile> readNamedFile(const AssetReference& reference, const std::filesystem::path& file) {
  if (const v1::MeshSource* source = reference.mesh()) {
    return readMeshFile(file, importOptionsOf(*source)).map([](LocalMesh mesh) {
      return LocalFile{std::move(mesh.asset), mesh.report.text()};
    });
  }
  const bool isImage = reference.kind() == AssetKind::kScalarField;
  auto bytes = isImage ? importImage(file) : readAssetFile(file).map_error([&](const Error& error) {
    return Error{file.string(), error.reason};
  });
  if (!bytes) return tl::unexpected(std::move(bytes).error());
  const auto content = decodeAsset(reference.kind(), *bytes);
  if (!content) return refused(file.string(), content.error().text());
  std::string report = std::to_string(bytes->size()) + " bytes";
  return LocalFile{localAsset(reference.kind(), *std::move(bytes)), std::move(report)};
}

Result<void> outcomeOf(const v1::AssetUploadReply& reply, const std::filesystem::path& file) {
  if (!reply.accepted()) return refused(file.string() + ": " + reply.field(), reply.reason());
  return {};
}

std::string objectNameOf(const std::filesystem::path& file) {
  std::string name = file.stem().string().substr(0, kLongestName);
  std::ranges::replace_if(
      name,
      [](char c) {
        const bool isLetter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
        return !isLetter && (c < '0' || c > '9') && c != '-' && c != '.' && c != '_';
      },
      '_');
  return name.empty() ? "mesh" : name;
}

}  // namespace haptics
