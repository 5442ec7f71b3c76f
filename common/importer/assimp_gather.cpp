#include "common/importer/assimp_gather.h"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <initializer_list>
#include <limits>
#include <map>
#include <new>
#include <set>
#include <utility>
#include <vector>

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
#include "common/mesh/face_list.h"
#include "common/mesh/text_scan.h"
#include "common/mesh/tri_mesh.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

using Matrix = glm::dmat4;

/// Text in an archive that is read within 1 GB.
constexpr std::uint64_t kMaxUnpacked_bytes = 200'000'000;

/// Names in a refusal.
constexpr std::size_t kMaxNamesSaid = 8;

/// Of what Assimp says.
std::string words(std::string_view said) {
  constexpr std::size_t kMaxSaid = 200;
  return '"' + printable(said.substr(0, kMaxSaid)) + '"';
}

/// How the format is called, and what a file's name has to end in for Assimp.
struct Format {
  const char* name;
  const char* ending;
};
Format formatOf(MeshFormat format) {
  switch (format) {
    case MeshFormat::kGltf:
      return {"glTF", "gltf"};
    case MeshFormat::kGlb:
      return {"binary glTF", "gltf"};
    case MeshFormat::kCollada:
      return {"COLLADA", "dae"};
    case MeshFormat::k3mf:
      return {"3MF", "3mf"};
    case MeshFormat::k3ds:
      return {"3DS", "3ds"};
    case MeshFormat::kFbx:
      return {"FBX", "fbx"};
    default:
      return {"X3D", "x3d"};
  }
}

/// The file, and those beside it that the reader gives, each asked for once.
class Files final : public Assimp::IOSystem {
 public:
  Files(std::string name, const std::string& bytes, const IncludeReader& readIncluded)
      : name_(std::move(name)), bytes_(bytes), readIncluded_(readIncluded) {}

  /// The first that was not given.
  [[nodiscard]] const std::string& missing() const { return missing_; }
  [[nodiscard]] std::size_t includedBytes() const { return includedBytes_; }

  /// A file that is not asked for.
  void give(const std::string& name, std::string bytes) { included_[name] = std::move(bytes); }

  bool Exists(const char* name) const override { return find(name) != nullptr; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* /*mode*/) override {
    const std::string* const bytes = find(name);
    if (bytes == nullptr) return nullptr;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes->data()), bytes->size());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::string* find(std::string_view name) const {
    if (name.starts_with("./")) name.remove_prefix(2);
    if (name == name_) return &bytes_;
    const auto [at, isNew] = included_.try_emplace(std::string(name));
    if (isNew) {
      at->second = readIncluded_(at->first);
      if (!at->second) at->second = readIncluded_(withoutPercents(at->first));
      if (at->second) includedBytes_ += at->second->size();
      if (!at->second && missing_.empty()) missing_ = at->first;
    }
    return at->second ? &*at->second : nullptr;
  }

  const std::string name_;
  const std::string& bytes_;
  const IncludeReader& readIncluded_;
  mutable std::map<std::string, std::optional<std::string>> included_;
  mutable std::string missing_;
  mutable std::size_t includedBytes_ = 0;
};

/// What Assimp says of a file that it reads in spite of it, while this lives.
class Log final : public Assimp::LogStream {
 public:
  Log() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0, nullptr);
    Assimp::DefaultLogger::get()->attachStream(this, Assimp::Logger::Warn | Assimp::Logger::Err);
  }
  ~Log() override {
    Assimp::DefaultLogger::get()->detachStream(this, Assimp::Logger::Warn | Assimp::Logger::Err);
    Assimp::DefaultLogger::kill();
  }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  [[nodiscard]] bool ranOutOfMemory() const { return ranOutOfMemory_; }
  /// Meshes and nodes of an FBX that it left out, and the first reason.
  [[nodiscard]] std::uint64_t leftOut() const { return leftOut_; }
  [[nodiscard]] const std::string& reason() const { return reason_; }
  /// Whether it has put another vertex in the place of one that is not there.
  [[nodiscard]] bool movedIndices() const { return movedIndices_; }

  void write(const char* message) override {
    const std::string_view text = message;
    const bool isFault = text.find("Error") != text.npos && text.find("FBX-DOM (") != text.npos;
    ranOutOfMemory_ = ranOutOfMemory_ || text.find("bad_alloc") != text.npos;
    movedIndices_ = movedIndices_ || text.find("index overflow") != text.npos;
    if (isFault && ++leftOut_ == 1) reason_ = text.substr(text.find("FBX-DOM"), text.find('\n') - text.find("FBX-DOM"));
  }

 private:
  bool ranOutOfMemory_ = false, movedIndices_ = false;
  std::uint64_t leftOut_ = 0;
  std::string reason_;
};

/// An attribute of the first element of this name in an XML text; empty: there is none.
std::string attributeOf(std::string_view text, std::string_view element, std::string_view attribute) {
  std::string found;
  eachTag(text, [&](const XmlTag& tag) {
    if (tag.ends || tag.name != element) return true;
    found = attributeIn(tag.inside, attribute);
    return false;
  });
  return found;
}

/// Its point may be a comma.
std::optional<double> positive(std::string text) {
  std::ranges::replace(text, ',', '.');
  text.erase(0, std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !(value > 0) || value > std::numeric_limits<double>::max()) return std::nullopt;
  return value;
}

using Names = std::map<std::string, std::string, std::less<>>;

/// What is known of a file before it is read.
struct Beforehand {
  std::optional<double> unit_m = std::nullopt;
  std::optional<std::uint64_t> triangles = std::nullopt;        ///< Of glTF.
  std::vector<std::pair<std::string, std::string>> given = {};  ///< Files beside it, each its name and its bytes.
  std::optional<std::uint64_t> shapesSkipped = std::nullopt;    ///< Where Assimp does not see them.
  std::uint64_t shapesOfFbx = 0;                                ///< Likewise, beside those that it says.
  std::string fault = {};                                       ///< Of a mesh that Assimp leaves out, in our words.
  std::optional<LeftOut> leftOut = std::nullopt;                ///< Where Assimp does not see it.
  Vec3 centre{0};                                               ///< See moveToOrigin().
  std::size_t includedBytes = 0;                                ///< Of files that are in the text by now.
  Names names = {};                                             ///< That a person gave, by Assimp's.
};

Result<void> checkUnpacked(const ZipArchive& archive) {
  if (archive.size_bytes() <= kMaxUnpacked_bytes) return {};
  return refused("", "unpacks to " + std::to_string(archive.size_bytes()) + " bytes; at most " +
                         std::to_string(kMaxUnpacked_bytes) + " are taken");
}

/// Where the text of COLLADA is in an archive.
Result<ZipArchive::Entry> textIn(const ZipArchive& archive, const std::string& ending) {
  if (auto fits = checkUnpacked(archive); !fits) return tl::unexpected(std::move(fits).error());
  std::vector<const ZipArchive::Entry*> texts;
  for (const ZipArchive::Entry& entry : archive.entries()) {
    if (inLowerCase(entry.name).ends_with(ending)) texts.push_back(&entry);
  }
  if (texts.empty()) return refused("", "is a ZIP archive without a file that ends in " + ending);
  if (texts.size() > 1) {
    return refused("", "is an archive of " + std::to_string(texts.size()) + " files that end in " + ending +
                           "; one that holds all is read");
  }
  return *texts.front();
}

/// Names of the elements that have an id, of which Assimp makes a name, behind `prefix`.
Names namesIn(std::string_view text, std::initializer_list<std::string_view> elements, const std::string& prefix) {
  Names names;
  eachTag(text, [&](const XmlTag& tag) {
    if (tag.ends || std::ranges::find(elements, tag.name) == elements.end()) return true;
    const std::string_view id = attributeIn(tag.inside, "id"), name = attributeIn(tag.inside, "name");
    if (!id.empty() && !name.empty()) names.emplace(prefix + std::string(id), withoutEntities(name));
    return true;
  });
  return names;
}

Result<Beforehand> lookAtCollada(std::string& file) {
  if (ZipArchive::isOne(file)) {
    const auto archive = ZipArchive::open(file);
    if (!archive) return tl::unexpected(archive.error());
    auto text =
        textIn(*archive, ".dae").and_then([&](const ZipArchive::Entry& entry) { return archive->unpacked(entry); });
    if (!text) return tl::unexpected(std::move(text).error());
    file = *std::move(text);
  }
  return plainXml(std::move(file))
      .and_then([](const std::string& text) {
        return checkNesting(text, "COLLADA").and_then([&] { return preparedCollada(text); });
      })
      .map([&](ColladaText collada) {
        file = std::move(collada.text);
        return Beforehand{.unit_m = positive(collada.unit),
                          .shapesSkipped = collada.skipped,
                          .leftOut = collada.leftOut,
                          .centre = moveToOrigin(file, MeshFormat::kCollada),
                          .names = namesIn(file, {"node", "geometry"}, "")};
      });
}

/// The models of a 3MF, the one first that its relationships name.
Result<std::vector<Model3mf>> modelsIn(const ZipArchive& archive) {
  std::string first = "3D/3dmodel.model";
  std::vector<Model3mf> models;
  for (const ZipArchive::Entry& entry : archive.entries()) {
    const bool isModel = inLowerCase(entry.name).ends_with(".model");
    if (!isModel && entry.name != "_rels/.rels") continue;
    auto text = archive.unpacked(entry).and_then(plainXml);
    if (!text) return tl::unexpected(std::move(text).error());
    if (auto ok = checkNesting(*text, isModel ? "model" : "Relationships"); !ok) {
      return refused("", "has " + inQuotes(entry.name) + ", which " + ok.error().reason);
    }
    if (isModel) {
      models.push_back({entry.name, *std::move(text)});
      continue;
    }
    eachTag(*text, [&](const XmlTag& tag) {
      if (!attributeIn(tag.inside, "Type").ends_with("/3dmodel")) return true;
      first = attributeIn(tag.inside, "Target");
      if (first.starts_with('/')) first.erase(0, 1);
      return false;
    });
  }
  if (models.empty()) return refused("", "is a ZIP archive without a file that ends in .model");
  const auto at = std::ranges::find_if(models, [&](const Model3mf& each) { return isOnePath(each.name, first); });
  if (at == models.end() && models.size() > 1)
    return refused("", "has no model " + inQuotes(first) + ", with which it begins");
  if (at != models.end()) std::iter_swap(models.begin(), at);
  models.front().name = first;  // where Assimp looks for it
  return models;
}

/// Pictures, settings and whatever else the archive has are left out: Assimp may crash on them.
Result<Beforehand> lookAt3mf(std::string& file) {
  if (!ZipArchive::isOne(file)) return refused("", "is no 3MF: it is no ZIP archive");
  const auto archive = ZipArchive::open(file);
  if (!archive) return tl::unexpected(archive.error());
  if (auto fits = checkUnpacked(*archive); !fits) return tl::unexpected(std::move(fits).error());
  auto models = modelsIn(*archive);
  if (!models) return tl::unexpected(std::move(models).error());
  const std::string name = models->front().name;
  LeftOut leftOut;
  for (const Model3mf& model : *models) {
    eachTag(model.text, [&](const XmlTag& tag) {
      leftOut.lines += !tag.ends && tag.name == "beam" ? 1 : 0;
      return true;
    });
  }
  auto text = joined(*std::move(models));
  if (!text) return tl::unexpected(std::move(text).error());
  if (auto ok = checkModel3mf(*text); !ok) return tl::unexpected(std::move(ok).error());
  Beforehand known{.leftOut = leftOut};
  known.unit_m = unitOf3mf(attributeOf(*text, "model", "unit"));
  known.centre = moveToOrigin(*text, MeshFormat::k3mf);
  known.names = namesIn(*text, {"object"}, "Object_");
  std::vector<std::pair<std::string, std::string>> read;
  for (const ZipArchive::Entry& entry : archive->entries()) {
    if (entry.name != "[Content_Types].xml" && !entry.name.ends_with(".rels")) continue;
    auto other = archive->unpacked(entry).and_then(plainXml);
    if (!other) return tl::unexpected(std::move(other).error());
    read.emplace_back(entry.name, *std::move(other));
  }
  read.emplace_back(name, *std::move(text));
  file = ZipArchive::of(read);
  return known;
}

Result<Beforehand> lookAtX3d(std::string& file, const IncludeReader& readIncluded) {
  std::size_t includedBytes = 0;
  const IncludeReader read = [&](const std::string& name) {
    auto bytes = readIncluded(name);
    const std::string plain = withoutPercents(name);
    return bytes || plain == name ? std::move(bytes) : readIncluded(plain);
  };
  return x3dInXml(std::move(file))
      .and_then([&](const std::string& text) {
        return checkNesting(text, "X3D").and_then([&] { return withInlines(text, read); });
      })
      .and_then([&](InlinedX3d inlined) {
        includedBytes = inlined.bytes;
        return withGroupsInPlace(std::move(inlined.text));
      })
      .and_then([&](const std::string& text) {
        return checkNesting(text, "X3D").and_then([&] { return preparedX3d(text); });
      })
      .map([&](X3dText x3d) {
        file = std::move(x3d.text);
        return Beforehand{.unit_m = positive(x3d.unit),
                          .shapesSkipped = x3d.skipped,
                          .leftOut = LeftOut{.unshown = x3d.unshown},
                          .centre = moveToOrigin(file, MeshFormat::kX3d),
                          .includedBytes = includedBytes};
      });
}

/// @param file  Afterwards, what Assimp is to read.
Result<Beforehand> lookAt(std::string& file, MeshFormat format, const IncludeReader& readIncluded) {
  const std::size_t most = kMaxOfFewBytes + file.size();
  const bool isXml = format == MeshFormat::kCollada || format == MeshFormat::kX3d;
  if (!isXml && (file.starts_with("\xff\xfe") || file.starts_with("\xfe\xff"))) {
    return refused("", "is in UTF-16; save it in UTF-8");
  }
  switch (format) {
    case MeshFormat::kGltf:
    case MeshFormat::kGlb:
      return preparedGltf(std::move(file), most, readIncluded).map([&](Gltf gltf) {
        file = std::move(gltf.file);
        return Beforehand{.unit_m = 1,
                          .triangles = gltf.triangles,
                          .given = {{kGltfPositions, std::move(gltf.positions)}, {kGltfBinary, std::move(gltf.binary)}},
                          .shapesSkipped = gltf.skipped,
                          .leftOut = gltf.leftOut};
      });
    case MeshFormat::k3mf:
      return lookAt3mf(file);
    case MeshFormat::kCollada:
      return lookAtCollada(file);
    case MeshFormat::kX3d:
      return lookAtX3d(file, readIncluded);
    case MeshFormat::kFbx:
      return preparedFbx(std::move(file)).map([&](FbxFile fbx) {
        file = std::move(fbx.file);
        return Beforehand{.shapesOfFbx = fbx.skipped,
                          .fault = std::move(fbx.fault),
                          .leftOut = fbx.leftOut,
                          .centre = moveToOrigin(file, format)};
      });
    default:
      return checked3ds(file).map(
          [](std::uint64_t hidden) { return Beforehand{.leftOut = LeftOut{.unshown = hidden}}; });
  }
}

Matrix matrixOf(const aiMatrix4x4& m) {
  return {m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2, m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4, m.d4};
}

/// A node that has meshes, and where they are.
struct Placed {
  const aiNode* node;
  Matrix toRoot;
};

Result<std::vector<Placed>> placedIn(const aiScene& scene, const Matrix& toRoot, std::size_t mostNodes) {
  std::vector<Placed> found, left{{scene.mRootNode, toRoot}};
  std::size_t nodes = 0;
  while (!left.empty()) {
    const Placed at = left.back();
    left.pop_back();
    if (at.node == nullptr) continue;
    if (++nodes > mostNodes) return refused("", "leads to more than " + std::to_string(mostNodes) + " nodes");
    const Matrix own = at.toRoot * matrixOf(at.node->mTransformation);
    if (at.node->mNumMeshes > 0) found.push_back({at.node, own});
    for (unsigned i = at.node->mNumChildren; i-- > 0;) left.push_back({at.node->mChildren[i], own});
  }
  return found;
}

/// Undoes what Assimp has put into the root of a 3DS: turned so that y is up, and before that scaled by its MASTER_SCALE.
Matrix toFilesAxes(const aiScene& scene, MeshFormat format) {
  const Matrix turned = matrixOf({1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1});
  if (format != MeshFormat::k3ds || scene.mRootNode == nullptr) return Matrix(1);
  const Matrix root = matrixOf(scene.mRootNode->mTransformation), scaled = glm::inverse(turned) * root;
  return scaled == Matrix(glm::dmat3(scaled[0][0])) ? glm::inverse(turned) : Matrix(1);
}

std::string_view textOf(const aiString& text) {
  return {text.data, std::min<std::size_t>(text.length, sizeof text.data)};
}

/// Of a glTF's mesh of several primitives, Assimp makes "name-0", "name-1".
bool isNamed(std::string_view name, std::string_view part) {
  if (!name.starts_with(part)) return false;
  name.remove_prefix(part.size());
  return name.empty() || (name.size() > 1 && name[0] == '-' && name.find_first_not_of("0123456789", 1) == name.npos);
}

class Gathering {
 public:
  /// @param centre  What is added to each position before it is placed.
  /// @param names  As Beforehand has them.
  Gathering(const aiScene& scene, std::size_t maxTriangles, const Vec3& centre, const Names& names)
      : scene_(scene), maxTriangles_(maxTriangles), centre_(centre), names_(names) {
    found.leftOut.animations = scene.mNumAnimations;
  }

  PolygonSoup found;

  Result<void> take(const std::vector<Placed>& placed, std::string_view part) {
    std::size_t number = std::numeric_limits<std::size_t>::max();
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    const bool isNumber = error == std::errc() && end == part.data() + part.size();
    const bool anyNamed = !part.empty() && std::any_of(placed.begin(), placed.end(),
                                                       [&](const Placed& at) { return hasName(*at.node, part); });
    double farthestPlace = 0;  // nodes are float32, too
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const bool isAsked = part.empty() || (anyNamed ? hasName(*placed[i].node, part) : isNumber && i == number);
      ++(isAsked ? found.meshesTaken : found.meshesLeft);
      const Vec3 place = glm::abs(Vec3(placed[i].toRoot[3]));
      if (isAsked) farthestPlace = std::max(farthestPlace, float32Rounding(std::max({place.x, place.y, place.z})));
      for (unsigned k = 0; isAsked && k < placed[i].node->mNumMeshes; ++k) {
        const unsigned mesh = placed[i].node->mMeshes[k];
        if (mesh >= scene_.mNumMeshes) continue;
        if (auto ok = add(*scene_.mMeshes[mesh], placed[i].toRoot); !ok) return ok;
      }
    }
    if (found.meshesTaken > 1) found.rounding += farthestPlace;
    if (found.meshesTaken == 0 && !part.empty()) return refused("part", "is no mesh of the file: " + listOf(placed));
    return {};
  }

 private:
  const aiScene& scene_;
  const std::size_t maxTriangles_;
  const Vec3 centre_;
  const Names& names_;

  /// The one that a person gave, or Assimp's.
  [[nodiscard]] std::string_view nameOf(const aiString& name) const {
    const auto given = names_.find(textOf(name));
    return given != names_.end() ? given->second : textOf(name);
  }

  [[nodiscard]] bool hasName(const aiNode& node, std::string_view part) const {
    if (textOf(node.mName) == part || nameOf(node.mName) == part) return true;
    for (unsigned k = 0; k < node.mNumMeshes; ++k) {
      if (node.mMeshes[k] >= scene_.mNumMeshes) continue;
      const aiString& name = scene_.mMeshes[node.mMeshes[k]]->mName;
      if (isNamed(textOf(name), part) || isNamed(nameOf(name), part)) return true;
    }
    return false;
  }

  [[nodiscard]] std::string listOf(const std::vector<Placed>& placed) {
    if (placed.empty()) return "it has none";
    std::string list = "it has ";
    for (std::size_t i = 0; i < std::min(placed.size(), kMaxNamesSaid); ++i) {
      list += (i > 0 ? ", " : "") + std::to_string(i) + ' ' + inQuotes(nameOf(placed[i].node->mName));
    }
    return list +
           (placed.size() > kMaxNamesSaid ? " and " + std::to_string(placed.size() - kMaxNamesSaid) + " more" : "");
  }

  /// A mesh whose indices may be anything.
  Result<void> add(const aiMesh& mesh, const Matrix& toRoot) {
    if (mesh.mNumVertices > 0 && mesh.mVertices == nullptr) return refused("", "has a mesh without vertices");
    if (found.triangles.size() + mesh.mNumFaces > maxTriangles_ ||
        found.vertices.size() + mesh.mNumVertices > 3 * maxTriangles_) {
      return refused("", "makes more than " + std::to_string(maxTriangles_) + " triangles by repeating meshes");
    }
    found.leftOut.skins += mesh.mNumBones > 0 ? 1 : 0;
    found.leftOut.morphs += mesh.mNumAnimMeshes > 0 ? 1 : 0;
    const auto first = static_cast<std::int64_t>(found.vertices.size());
    double largest = 0;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& at = mesh.mVertices[v];
      for (const float coordinate : {at.x, at.y, at.z})
        largest = std::max(largest, std::abs(static_cast<double>(coordinate)));
      found.vertices.emplace_back(toRoot * glm::dvec4(Vec3(at.x, at.y, at.z) + centre_, 1));
    }
    const double scale = std::max({glm::length(toRoot[0]), glm::length(toRoot[1]), glm::length(toRoot[2])});
    found.rounding = std::max(found.rounding, float32Rounding(largest) * scale);
    const bool isMirrored = glm::determinant(glm::dmat3(toRoot)) < 0;
    std::vector<std::uint32_t> corners;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) {
        ++(face.mNumIndices == 2 ? found.leftOut.lines : found.leftOut.points);
        continue;
      }
      corners.clear();
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const bool isThere = face.mIndices[k] < mesh.mNumVertices;
        corners.push_back(found.numbered(isThere ? first + face.mIndices[k] : -1));
      }
      if (isMirrored) std::reverse(corners.begin() + 1, corners.end());
      if (auto ok = addFace(corners, 0, found); !ok) return ok;
    }
    return {};
  }
};

/// Meshes that no node shows.
std::uint64_t unshownIn(const aiScene& scene, const std::vector<Placed>& placed) {
  std::set<unsigned> shown;
  for (const Placed& at : placed) shown.insert(at.node->mMeshes, at.node->mMeshes + at.node->mNumMeshes);
  return scene.mNumMeshes - std::min<std::uint64_t>(shown.size(), scene.mNumMeshes);
}

/// Each mesh once, as GltfTriangles counts.
std::uint64_t trianglesIn(const aiScene& scene) {
  std::uint64_t triangles = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    triangles += static_cast<std::uint64_t>(std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                                                          [](const aiFace& face) { return face.mNumIndices > 2; }));
  }
  return triangles;
}

tl::unexpected<Error> noMeshShown(const Beforehand& known) {
  const std::uint64_t unshown = known.leftOut ? known.leftOut->unshown : 0;
  return refused("", "holds no mesh that its scene shows" +
                         (unshown > 0 ? "; hidden, or without a place in it: " + std::to_string(unshown) : ""));
}

tl::unexpected<Error> notRead(const char* format, const Assimp::Importer& importer, const Files& files,
                              const Beforehand& known) {
  const std::string said = importer.GetErrorString();
  const auto says = [&](const char* what) { return said.find(what) != said.npos; };
  if (says("has no faces") && known.triangles.value_or(0) > 0)
    return refused("", "holds a mesh of which every triangle names a vertex that is not there");
  if (says("exceeds size of actual data"))
    return refused("", "has a buffer whose byteLength is more than the bytes of the file that its uri names");
  if (says("No faces loaded") && known.leftOut && known.leftOut->unshown > 0) return noMeshShown(known);
  if (!files.missing().empty()) {
    return refused(
        "", "names the file " + inQuotes(files.missing()) +
                ", which is not in its folder or below, where alone files are looked for; a .glb holds all in one");
  }
  if (says("Draco")) {
    return refused("",
                   "has a primitive whose KHR_draco_mesh_compression cannot be unpacked: Assimp says " + words(said));
  }
  return refused("", std::string("cannot be read as ") + format + ": Assimp says " + words(said));
}

}  // namespace

Result<PolygonSoup> gatherByAssimp(std::string file, MeshFormat format, const PartName& part,
                                   const IncludeReader& readIncluded) {
  const Format names = formatOf(format);
  const std::size_t fileSize = file.size();
  auto known = lookAt(file, format, readIncluded);
  if (!known) return tl::unexpected(known.error());

  const std::string name = std::string("mesh.") + names.ending;
  auto* const files = new Files(name, file, readIncluded);
  for (auto& [beside, bytes] : known->given) files->give(beside, std::move(bytes));
  const Log log;
  Assimp::Importer importer;
  importer.SetIOHandler(files);  // which owns it from now on
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
#ifdef AI_CONFIG_IMPORT_FBX_IGNORE_UP_DIRECTION
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_IGNORE_UP_DIRECTION, true);
#endif
  const aiScene* const scene = importer.ReadFile(name, 0);
  if (log.ranOutOfMemory()) throw std::bad_alloc();
  if (scene == nullptr) return notRead(names.name, importer, *files, *known);
  if (log.movedIndices()) return refused("", "has triangles that name a vertex that is not there");

  const std::size_t most =
      std::min<std::size_t>(kMaxTriangles, kMaxOfFewBytes + fileSize + known->includedBytes + files->includedBytes());
  std::optional<double> unit_m = known->unit_m;
  float centimetres = 0;
  if (format == MeshFormat::kFbx && scene->mMetaData != nullptr &&
      scene->mMetaData->Get("UnitScaleFactor", centimetres) && centimetres > 0) {
    unit_m = static_cast<double>(centimetres) * 1e-2;
  }
  const auto placed = placedIn(*scene, toFilesAxes(*scene, format), most);
  if (!placed) return tl::unexpected(placed.error());
  if (placed->empty() && known->shapesSkipped.value_or(0) + known->shapesOfFbx == 0) {
    if (!known->fault.empty()) return refused("", "holds no mesh that can be read: " + known->fault);
    if (log.leftOut() > 0) return refused("", "holds no mesh that can be read: Assimp says " + words(log.reason()));
    return noMeshShown(*known);
  }
  Gathering gathering(*scene, most, known->centre, known->names);
  if (auto ok = gathering.take(*placed, part.text()); !ok) return tl::unexpected(std::move(ok).error());
  gathering.found.unit_m = unit_m;
  gathering.found.shapesSkipped = log.leftOut() + known->shapesOfFbx;
  if (known->shapesSkipped) {
    gathering.found.shapesSkipped = *known->shapesSkipped;
    if (format == MeshFormat::kX3d) gathering.found.leftOut.points = 0;  // lines among them
  }
  LeftOut& left = gathering.found.leftOut;
  if (known->leftOut) {
    left.lines += known->leftOut->lines;
    left.skins += known->leftOut->skins;
    left.morphs += known->leftOut->morphs;
    left.instances += known->leftOut->instances;
    left.unshown += known->leftOut->unshown;
  }
  if (format == MeshFormat::k3mf) left.unshown += unshownIn(*scene, *placed);
  if (const std::uint64_t there = trianglesIn(*scene); known->triangles && *known->triangles > there) {
    gathering.found.outOfRange += *known->triangles - there;
  }
  return std::move(gathering.found);
}

}  // namespace haptics
