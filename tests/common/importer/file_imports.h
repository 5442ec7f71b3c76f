#pragma once

#include "common/importer/importer.h"
#include "common/mesh/mesh_asset.h"
#include "tests/common/mesh/mesh_files.h"

namespace haptics::fixture {

/// Files that are imported as the programs do it, by the asset importer.
class FileImports : public MeshFiles {
 protected:
  static Result<ImportedMesh> importFile(const std::filesystem::path& file, const std::filesystem::path& within,
                                         const ImportOptions& options = {}) {
    return importMeshFile(file, within, options).and_then([](const EncodedMesh& imported) {
      return decodeMesh(imported.bytes).map([&](TriMesh mesh) {
        return ImportedMesh{std::move(mesh), imported.report};
      });
    });
  }
  Result<ImportedMesh> import(const std::string& name, std::string_view content,
                              const ImportOptions& options = {}) const {
    const auto file = write(name, content);
    return importFile(file, file.parent_path(), options);
  }

  /// Why the file was refused; "loaded" if it was not.
  std::string refusal(const std::string& name, std::string_view content) const {
    const auto imported = import(name, content);
    if (imported) return "loaded";
    EXPECT_EQ(imported.error().field, (folder_ / name).string()) << "the error should name the file";
    return imported.error().reason;
  }
};

}  // namespace haptics::fixture
