#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "common/importer/assimp_gather.h"
#include "common/importer/import_request.h"
#include "common/importer/inventor_gather.h"
#include "common/importer/sandbox.h"
#include "common/importer/unpacked.h"
#include "common/mesh/file_bytes.h"
#include "common/mesh/mesh_asset.h"
#include "common/process/passed_descriptor.h"
#include "common/surface/field_asset.h"
#include "common/surface/makers/grown_reaction_diffusion.h"
#include "common/surface/makers/image_field.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/point_field_asset.h"

// Started by importer.cpp only, which is at the other end of standard input.
namespace haptics {
namespace {

constexpr int kSocket = STDIN_FILENO;

struct Answer {
  std::string bytes;
  MeshReport report = {};
};

/// Everything, or this process ends: there is nobody to tell.
void say(const void* bytes, std::size_t size) {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t sent = sendWith(kSocket, at, size, -1);
    if (sent <= 0) _exit(EXIT_FAILURE);
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

void say(ImporterMessage::Kind kind, std::string_view bytes, const MeshReport& report = {}) {
  ImporterMessage message;
  message.kind = kind;
  message.size = bytes.size();
  message.report = report;
  say(&message, sizeof message);
  say(bytes.data(), bytes.size());
}

std::optional<std::string> askForExactly(const std::string& name) {
  if (name.size() > kLongestInclude) return std::nullopt;
  say(ImporterMessage::Kind::kInclude, name);
  IncludeReply reply = IncludeReply::kNo;
  FileHandle file;
  if (receiveWith(kSocket, &reply, sizeof reply, file) != sizeof reply) _exit(EXIT_FAILURE);
  if (reply != IncludeReply::kYes || !file) return std::nullopt;
  auto bytes = readFile(file);
  if (!bytes) return std::nullopt;
  return *std::move(bytes);
}

/// A file that the file includes; some write the ways to them with backslashes.
std::optional<std::string> askFor(const std::string& name) {
  auto bytes = askForExactly(name);
  if (bytes || name.find('\\') == name.npos) return bytes;
  std::string plain = name;
  std::ranges::replace(plain, '\\', '/');
  return askForExactly(plain);
}

/// Whether a library is at work that may take any time on a file that was made for it to.
volatile std::sig_atomic_t reading = false;

/// Processor time that Assimp or Coin gets for a file, seconds: three times what it takes of the slowest format.
unsigned readingTime_s(std::uintmax_t file_bytes) {
  constexpr std::uintmax_t kAtLeast_s = 4, kBytesPerSecond = 1'000'000;
  return static_cast<unsigned>(kAtLeast_s + file_bytes / kBytesPerSecond);
}

/// For 400 bytes a triangle, which importing takes, where a file has 12 for it.
std::uintmax_t readingMemory_bytes(std::uintmax_t file_bytes) { return (std::uintmax_t{1} << 30) + 32 * file_bytes; }

void refuseIfReading(int) {
  if (!reading) return;
  using std::string_view_literals::operator""sv;
  say(ImporterMessage::Kind::kRefused, "\0takes its reader too long for a file of its size"sv);
  _exit(EXIT_SUCCESS);
}

struct Carrier {
  const FileHandle& file;

  Result<Answer> operator()(const MeshFileRequest& request) const {
    return readFile(file)
        .and_then(unpacked)
        .and_then([&](std::string bytes) -> Result<ImportedMesh> {
          const MeshReader reader = readerOf(request.format);
          if (reader == MeshReader::kOwn) return importMesh(bytes, request.format, request.options);
          return (reader == MeshReader::kCoin
                      ? gatherInventor(bytes, askFor)
                      : gatherByAssimp(std::move(bytes), request.format, request.options.part, askFor))
              .and_then([&](PolygonSoup soup) {
                reading = false;
                return importSoup(std::move(soup), request.options);
              });
        })
        .map([](const ImportedMesh& imported) {
          return Answer{encodeMesh(imported.mesh), imported.report};
        });
  }
  Result<Answer> operator()(const ImageRequest&) const {
    return readFile(file)
        .and_then([](const std::string& bytes) { return fieldFromImage(bytes); })
        .map([](const SampledField& field) { return Answer{encodeField(field)}; });
  }
  Result<Answer> operator()(const MeshRecipe& recipe) const {
    return generate(recipe).map([](const TriMesh& mesh) { return Answer{encodeMesh(mesh)}; });
  }
  Result<Answer> operator()(const ReactionDiffusionSource& s) const {
    return Answer{encodeField(reactionDiffusion(s))};
  }
  Result<Answer> operator()(const GrownRequest& request) const {
    return readFile(file)
        .and_then([](const std::string& bytes) { return decodeMesh(bytes); })
        .and_then([&](const TriMesh& mesh) { return grownReactionDiffusion(mesh, request.recipe); })
        .map([](const PointField& field) { return Answer{encodePointField(field)}; });
  }
};

Result<Answer> carryOut(const ImportRequest& request, const FileHandle& file) {
  try {
    return std::visit(Carrier{file}, request);
  } catch (const std::bad_alloc&) {
    return refused("", reading ? "needs more memory than a file of its size gets" : "needs more memory than there is");
  } catch (const std::length_error&) {
    return refused("", "needs more memory than there is");
  }
}

int run() {
  lowerPriorityAndLimit(kMaxImportTime_s);
  ImportRequest request;
  FileHandle file;
  if (receiveWith(kSocket, &request, sizeof request, file) != sizeof request) {
    std::fputs("this is started by the programs that import meshes and images; use mesh_report\n", stderr);
    return EXIT_FAILURE;
  }
  const auto* mesh = std::get_if<MeshFileRequest>(&request);
  const MeshReader reader = mesh != nullptr ? readerOf(mesh->format) : MeshReader::kOwn;
  if (reader == MeshReader::kCoin) startInventor();
  if (reader != MeshReader::kOwn) {
    struct stat status {};
    fstat(file.descriptor(), &status);
    const auto bytes = static_cast<std::uintmax_t>(status.st_size);
    reading = true;
    limitMore(readingMemory_bytes(bytes), readingTime_s(bytes), refuseIfReading);
  }

  const auto answer = enterSandbox().and_then([&] { return carryOut(request, file); });
  if (answer) {
    say(ImporterMessage::Kind::kDone, answer->bytes, answer->report);
  } else {
    const Error& error = answer.error();
    say(ImporterMessage::Kind::kRefused, (error.field + '\0' + error.reason).substr(0, kLongestRefusal));
  }
  // Without destructors: Coin's, and those of the font libraries that it loads, are slow and leak.
  _exit(EXIT_SUCCESS);
}

}  // namespace
}  // namespace haptics

int main() { return haptics::run(); }
