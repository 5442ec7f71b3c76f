#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/importer/mesh_recipe.h"
#include "common/mesh/file_bytes.h"
#include "common/mesh/import.h"
#include "common/scene/surface_edits.h"

// Files from anywhere, and what else takes long because its input says so, in a process of its own: the programs
// asset_importer, inventor_importer and assimp_importer, in the folder that the environment variable HAPTICS_PROGRAMS names, beside the
// running program, or where they were installed. It may be killed at any time, gets a file's descriptor and not its path,
// can open nothing, has no privileges and little priority (sandbox.h). So a file that crashes a library, or makes
// it compute for ever, costs its own import. All block the calling thread only, take five minutes at the most, and end at
// once when `stop` asks for it. Thread-safe.
namespace haptics {

struct EncodedMesh {
  std::string bytes;  ///< Canonical, not checked: as from anybody.
  MeshReport report;
  std::vector<FileStamp> included = {};  ///< The other files that it asked for, before they were read.
};

/// importMesh() of a file of any format, by the ending of its name; of .mesh, which holds a mesh's canonical bytes, those,
/// read in this process. Files that an Inventor, VRML or X3D file includes, and a glTF's buffers, are looked for in
/// its folder and below, and left out where they are not below `within` once symbolic links are followed. Errors have
/// the file or the option as their field: what importMesh() refuses, missing, empty, no regular file, damaged.
[[nodiscard]] Result<EncodedMesh> importMeshFile(const std::filesystem::path& file, const std::filesystem::path& within,
                                                 const ImportOptions& options, const std::stop_token& stop = {});
/// Imports a file of the user's own, which may include what is below its folder.
[[nodiscard]] Result<EncodedMesh> importMeshFile(const std::filesystem::path& file, const ImportOptions& options);

/// fieldFromImage() of a file, or what a .field file holds; canonical bytes of a field, not checked.
[[nodiscard]] Result<std::string> importImage(const std::filesystem::path& file, const std::stop_token& stop = {});

/// Canonical bytes of what generate(), reactionDiffusion() and grownReactionDiffusion() make, not checked.
[[nodiscard]] Result<std::string> makeInImporterProcess(const MeshRecipe& recipe, const std::stop_token& stop = {});
[[nodiscard]] Result<std::string> makeInImporterProcess(const ReactionDiffusionSource& recipe,
                                                        const std::stop_token& stop = {});
[[nodiscard]] Result<std::string> makeInImporterProcess(const GrownReactionDiffusionSource& recipe, const TriMesh& mesh,
                                                        const std::stop_token& stop = {});

}  // namespace haptics
