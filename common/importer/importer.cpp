#include "common/importer/importer.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

#include "common/importer/child_process.h"
#include "common/importer/import_request.h"
#include "common/mesh/file_bytes.h"
#include "common/mesh/mesh_asset.h"
#include "common/mesh/topology.h"
#include "common/scene/asset_source.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

/// Time limit of a process that gets little of the processors.
constexpr std::chrono::seconds kPatience{kMaxImportTime_s};

/// The largest mesh's canonical bytes, header included.
constexpr std::size_t kMaxBytes = 64 + kMaxVertices * sizeof(Vec3f) + kMaxTriangles * sizeof(TriangleIndices);

/// Most files that one file may include, directly or not; ends a file that includes itself. The largest model known
/// includes 12.
constexpr int kMaxIncludes = 100;

Error cutOff() { return {"", "cannot be read: its importer was cut off"}; }

/// Where a file that is read looks for those that it includes.
struct Surroundings {
  fs::path folder;
  fs::path within;  // canonical
};

bool mayInclude(const fs::path& name) {
  const auto goesUp = [](const fs::path& part) { return part == ".."; };
  const fs::path plain = name.lexically_normal();
  return !plain.is_absolute() && std::none_of(plain.begin(), plain.end(), goesUp);
}

std::optional<FileHandle> openIncluded(const fs::path& name, const Surroundings& around) {
  std::error_code error;
  const fs::path file = fs::canonical(around.folder / name, error);
  if (error || std::ranges::mismatch(around.within, file).in1 != around.within.end()) return std::nullopt;
  auto opened = openFile(file);
  if (!opened) return std::nullopt;
  return *std::move(opened);
}

Error errorFrom(const std::string& said) {
  const std::size_t end = std::min(said.find('\0'), said.size());
  return {said.substr(0, end), said.substr(std::min(end + 1, said.size()))};
}

/// One import.
class Import {
 public:
  Import(const ImportRequest& request, const std::stop_token& stop)
      : request_(request), child_(programFor(request), kPatience, stop) {}

  Result<EncodedMesh> run(const FileHandle* file, const Surroundings* around) {
    try {
      auto sent = child_.send(&request_, sizeof request_, file != nullptr ? file->descriptor() : -1);
      if (!sent) return tl::unexpected(std::move(sent).error());
      return answer(around);
    } catch (const std::bad_alloc&) {
      return refused("", "needs more memory than there is");
    }
  }

 private:
  const ImportRequest& request_;
  ChildProcess child_;
  int includes_ = 0;
  std::vector<FileStamp> included_;

  /// Where the user says; beside this one; where it was installed, for programs that link the library.
  static fs::path programFor(const ImportRequest& request) {
    const auto* mesh = std::get_if<MeshFileRequest>(&request);
    constexpr std::array kByReader{"asset_importer", "inventor_importer", "assimp_importer"};
    const MeshReader reader = mesh != nullptr ? readerOf(mesh->format) : MeshReader::kOwn;
    const char* const name = kByReader.at(static_cast<std::size_t>(reader));
    if (const char* const folder = std::getenv("HAPTICS_PROGRAMS")) return fs::path(folder) / name;
    std::error_code error;
    const fs::path beside = fs::read_symlink("/proc/self/exe", error).parent_path() / name;
    return fs::exists(beside, error) ? beside : fs::path(HAPTICS_PROGRAMS_FOLDER) / name;
  }

  Result<EncodedMesh> answer(const Surroundings* around) {
    for (;;) {
      ImporterMessage message;
      if (auto got = child_.receive(&message, sizeof message); !got) return tl::unexpected(std::move(got).error());
      if (!holds(message)) return tl::unexpected(cutOff());
      auto bytes = child_.receive(message.size);
      if (!bytes) return tl::unexpected(std::move(bytes).error());
      if (message.kind == ImporterMessage::Kind::kRefused) return tl::unexpected(errorFrom(*bytes));
      if (message.kind == ImporterMessage::Kind::kDone)
        return EncodedMesh{*std::move(bytes), message.report, std::move(included_)};
      if (auto handed = handOver(*bytes, around); !handed) return tl::unexpected(std::move(handed).error());
    }
  }

  /// Whether it may be looked at: nothing that comes from there is trusted.
  static bool holds(const ImporterMessage& message) {
    const auto isFlag = [](const bool& flag) { return *reinterpret_cast<const unsigned char*>(&flag) <= 1; };
    return message.size <= mostOf(message.kind) && isFlag(message.report.repair.searched) &&
           isFlag(message.report.repair.finished) && isFlag(message.report.tJunctionsSearched) &&
           isFlag(message.report.isUnitKnown);
  }

  static std::size_t mostOf(ImporterMessage::Kind kind) {
    switch (kind) {
      case ImporterMessage::Kind::kInclude:
        return kLongestInclude;
      case ImporterMessage::Kind::kRefused:
        return kLongestRefusal;
      case ImporterMessage::Kind::kDone:
        return kMaxBytes;
    }
    return 0;
  }

  Result<void> handOver(const std::string& name, const Surroundings* around) {
    std::optional<FileHandle> file;
    if (around != nullptr && ++includes_ <= kMaxIncludes && mayInclude(name)) {
      included_.push_back(stampOf(around->folder / name));
      file = openIncluded(name, *around);
    }
    const IncludeReply reply = file ? IncludeReply::kYes : IncludeReply::kNo;
    return child_.send(&reply, sizeof reply, file ? file->descriptor() : -1);
  }
};

Error naming(Error error, const fs::path& file) {
  if (error.field.empty()) error.field = file.string();
  return error;
}

Result<EncodedMesh> importFile(const fs::path& file, const ImportRequest& request, const Surroundings* around,
                               const std::stop_token& stop) {
  return openFile(file)
      .and_then([&](const FileHandle& opened) { return Import(request, stop).run(&opened, around); })
      .map_error([&](Error error) { return naming(std::move(error), file); });
}

bool holdsAsset(const fs::path& file, AssetKind kind) { return file.extension() == fileEndingOf(kind); }

Result<EncodedMesh> canonicalMeshIn(const fs::path& file, const ImportOptions& options) {
  if (options.unit_m || options.largestExtent_m) {
    return refused(options.largestExtent_m ? "largest_extent_m" : "unit_m",
                   "is for files of other programs; a .mesh file is in metres as it is: leave it out");
  }
  if (!options.part.text().empty())
    return refused("part", "is for files of several meshes; a .mesh file is one: leave it out");
  auto bytes = readAssetFile(file);
  if (!bytes) return tl::unexpected(naming(bytes.error(), file));
  const auto mesh = decodeMesh(*bytes);
  if (!mesh) return refused(file.string(), mesh.error().text());
  MeshReport report;
  report.trianglesInFile = report.kept = mesh->triangles.size();
  report.verticesInFile = mesh->vertices.size();
  report.isUnitKnown = true;
  describeTopology(*mesh, report);
  return EncodedMesh{*std::move(bytes), report};
}

Result<std::string> made(const ImportRequest& request, const std::stop_token& stop, const FileHandle* of = nullptr) {
  return Import(request, stop).run(of, nullptr).map([](EncodedMesh mesh) { return std::move(mesh.bytes); });
}

/// A file in memory, without a name.
Result<FileHandle> fileOf(const std::string& bytes) {
  FileHandle file(memfd_create("import", MFD_CLOEXEC));
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t written = write(file.descriptor(), bytes.data() + at, bytes.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return refused("", std::string("cannot be handed to its importer: ") + std::strerror(errno));
    at += static_cast<std::size_t>(written);
  }
  return file;
}

}  // namespace

Result<EncodedMesh> importMeshFile(const fs::path& file, const fs::path& within, const ImportOptions& options,
                                   const std::stop_token& stop) {
  if (holdsAsset(file, AssetKind::kMesh)) return canonicalMeshIn(file, options);
  const auto format = meshFormatOf(file);
  if (!format) return tl::unexpected(naming(format.error(), file));
  std::error_code error;
  const Surroundings around{file.parent_path(), fs::canonical(within.empty() ? "." : within, error)};
  const MeshReader reader = readerOf(*format);
  if (reader != MeshReader::kAssimp && !options.part.text().empty()) {
    return refused("part", "is for glTF, COLLADA, 3MF, 3DS, FBX and X3D; this file is read as one mesh");
  }
  const bool includes = reader != MeshReader::kOwn && !error;
  return importFile(file, MeshFileRequest{*format, options}, includes ? &around : nullptr, stop);
}

Result<EncodedMesh> importMeshFile(const fs::path& file, const ImportOptions& options) {
  return importMeshFile(file, file.parent_path(), options);
}

Result<std::string> importImage(const fs::path& file, const std::stop_token& stop) {
  if (holdsAsset(file, AssetKind::kScalarField)) {
    return readAssetFile(file).map_error([&](Error error) { return naming(std::move(error), file); });
  }
  return importFile(file, ImageRequest{}, nullptr, stop).map([](EncodedMesh made) { return std::move(made.bytes); });
}

Result<std::string> makeInImporterProcess(const MeshRecipe& recipe, const std::stop_token& stop) {
  return made(recipe, stop);
}

Result<std::string> makeInImporterProcess(const ReactionDiffusionSource& recipe, const std::stop_token& stop) {
  return made(recipe, stop);
}

Result<std::string> makeInImporterProcess(const GrownReactionDiffusionSource& recipe, const TriMesh& mesh,
                                          const std::stop_token& stop) {
  return fileOf(encodeMesh(mesh)).and_then([&](const FileHandle& file) {
    return made(GrownRequest{recipe}, stop, &file);
  });
}

}  // namespace haptics
