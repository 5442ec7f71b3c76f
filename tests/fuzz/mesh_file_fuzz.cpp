// A mesh file as people have them, behind a byte for its format: refused, or a mesh; of the formats that Assimp reads, what
// is to be handed to it.

#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/importer/chunks_3ds.h"
#include "common/importer/collada_text.h"
#include "common/importer/far_origin.h"
#include "common/importer/fbx_objects.h"
#include "common/importer/gltf_numbers.h"
#include "common/importer/joined_3mf.h"
#include "common/importer/model_3mf.h"
#include "common/importer/x3d_classic.h"
#include "common/importer/x3d_inlines.h"
#include "common/importer/x3d_text.h"
#include "common/importer/xml_text.h"
#include "common/importer/zip_archive.h"
#include "common/maths/vec.h"
#include "common/mesh/import.h"
#include "tests/fuzz/pieces.h"

namespace {

using namespace haptics;

constexpr MeshFormat kFormats[] = {MeshFormat::kObj,     MeshFormat::kPly, MeshFormat::kStl, MeshFormat::kOff,
                                   MeshFormat::kGltf,    MeshFormat::kGlb, MeshFormat::kX3d, MeshFormat::k3mf,
                                   MeshFormat::kCollada, MeshFormat::kFbx, MeshFormat::k3ds};

std::optional<std::string> noFile(const std::string& /*name*/) { return std::nullopt; }

void importWhole(std::string_view file, MeshFormat format) {
  const auto imported = importMesh(file, format, {.keepCrossings = true});
  if (!imported) return;
  const TriMesh& mesh = imported->mesh;
  fuzz::require(!mesh.triangles.empty(), "a mesh that is taken has triangles");
  for (const TriangleIndices& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) fuzz::require(corner < mesh.vertices.size(), "corners are vertices");
  }
  for (const Vec3f& vertex : mesh.vertices) fuzz::require(isFinite(Vec3(vertex)), "vertices are finite");
}

void prepare(std::string file, MeshFormat format) {
  const std::size_t most = kMaxOfFewBytes + file.size();
  const auto nested = [](const char* root) {
    return [root](std::string text) -> Result<std::string> {
      if (auto ok = checkNesting(text, root); !ok) return tl::unexpected(std::move(ok).error());
      return text;
    };
  };
  switch (format) {
    case MeshFormat::kGltf:
    case MeshFormat::kGlb:
      (void)preparedGltf(std::move(file), most, noFile);
      break;
    case MeshFormat::kX3d: {
      auto text = x3dInXml(std::move(file))
                      .and_then(nested("X3D"))
                      .and_then([](const std::string& plain) { return withInlines(plain, noFile); })
                      .and_then([](InlinedX3d inlined) { return withGroupsInPlace(std::move(inlined.text)); })
                      .and_then(nested("X3D"))
                      .and_then([](const std::string& plain) { return preparedX3d(plain); });
      if (text) (void)moveToOrigin(text->text, format);
      break;
    }
    case MeshFormat::kCollada: {
      auto text = plainXml(std::move(file)).and_then(nested("COLLADA")).and_then([](const std::string& plain) {
        return preparedCollada(plain);
      });
      if (text) (void)moveToOrigin(text->text, format);
      break;
    }
    case MeshFormat::k3mf: {
      auto text = plainXml(std::move(file)).and_then(nested("model")).and_then([](std::string plain) {
        return joined({Model3mf{"3D/3dmodel.model", std::move(plain)}});
      });
      if (text && checkModel3mf(*text)) (void)moveToOrigin(*text, format);
      break;
    }
    case MeshFormat::k3ds:
      (void)checked3ds(file);
      break;
    default:
      if (auto fbx = preparedFbx(std::move(file))) (void)moveToOrigin(fbx->file, format);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const MeshFormat format = kFormats[data[0] % std::size(kFormats)];
  const std::string_view file(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (const auto archive = ZipArchive::open(file)) {
    for (const ZipArchive::Entry& entry : archive->entries()) {
      if (entry.size_bytes < 1'000'000) (void)archive->unpacked(entry);
    }
  }
  if (readerOf(format) == MeshReader::kOwn) {
    importWhole(file, format);
  } else {
    prepare(std::string(file), format);
  }
  return 0;
}
