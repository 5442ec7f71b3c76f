#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

#include "common/importer/importer.h"
#include "common/importer/inventor_gather.h"
#include "common/mesh/file_bytes.h"
#include "common/mesh/mesh_asset.h"
#include "common/process/file_handle.h"
#include "common/surface/field_asset.h"
#include "common/surface/makers/grown_reaction_diffusion.h"
#include "common/surface/makers/image_field.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/point_field_asset.h"

// What common/importer/importer.cpp lets other programs do, in this process: an emulator of processors starts no other programs,
// and has no sandbox. The scenes are our own.
namespace haptics {
namespace fs = std::filesystem;
namespace {

Result<std::string> bytesOf(const fs::path& file) {
  return openFile(file).and_then([](const FileHandle& opened) { return readFile(opened); });
}

EncodedMesh encoded(const ImportedMesh& imported) { return {encodeMesh(imported.mesh), imported.report}; }

/// In a process of its own: Coin leaves nobody else files to open.
Result<EncodedMesh> importInventor(const std::string& bytes, const ImportOptions& options) {
  int ends[2];
  if (pipe(ends) != 0) return refused("", "has no pipe");
  const pid_t child = fork();
  if (child == 0) {
    startInventor();
    const auto made = gatherInventor(bytes, [](const std::string&) {
                        return std::nullopt;
                      }).and_then([&](PolygonSoup soup) { return importSoup(std::move(soup), options); });
    const std::string mesh = made ? encodeMesh(made->mesh) : std::string();
    for (std::size_t at = 0; at < mesh.size();) {
      const ssize_t written = write(ends[1], mesh.data() + at, mesh.size() - at);
      if (written <= 0) break;
      at += static_cast<std::size_t>(written);
    }
    _exit(0);
  }
  close(ends[1]);
  EncodedMesh mesh;
  char some[4096];
  for (ssize_t got = 0; (got = read(ends[0], some, sizeof some)) > 0;) {
    mesh.bytes.append(some, static_cast<std::size_t>(got));
  }
  close(ends[0]);
  waitpid(child, nullptr, 0);
  if (mesh.bytes.empty()) return refused("", "is an Inventor file that cannot be read here");
  return mesh;
}

}  // namespace

Result<EncodedMesh> importMeshFile(const fs::path& file, const fs::path& /*within*/, const ImportOptions& options,
                                   const std::stop_token& /*stop*/) {
  const auto format = meshFormatOf(file);
  if (!format) return tl::unexpected(format.error());
  return bytesOf(file).and_then([&](const std::string& bytes) -> Result<EncodedMesh> {
    if (*format == MeshFormat::kInventor) return importInventor(bytes, options);
    return importMesh(bytes, *format, options).map(encoded);
  });
}

Result<std::string> importImage(const fs::path& file, const std::stop_token& /*stop*/) {
  return bytesOf(file)
      .and_then([](const std::string& bytes) { return fieldFromImage(bytes); })
      .map([](const SampledField& field) { return encodeField(field); });
}

Result<std::string> makeInImporterProcess(const MeshRecipe& recipe, const std::stop_token& /*stop*/) {
  return generate(recipe).map([](const TriMesh& mesh) { return encodeMesh(mesh); });
}

Result<std::string> makeInImporterProcess(const ReactionDiffusionSource& recipe, const std::stop_token& /*stop*/) {
  return encodeField(reactionDiffusion(recipe));
}

Result<std::string> makeInImporterProcess(const GrownReactionDiffusionSource& recipe, const TriMesh& mesh,
                                          const std::stop_token& /*stop*/) {
  return grownReactionDiffusion(mesh, recipe).map([](const PointField& field) { return encodePointField(field); });
}

}  // namespace haptics
