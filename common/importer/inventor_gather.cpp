#include "common/importer/inventor_gather.h"

#include <Inventor/SbMatrix.h>
#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoInteraction.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/VRMLnodes/SoVRMLBillboard.h>
#include <Inventor/VRMLnodes/SoVRMLCone.h>
#include <Inventor/VRMLnodes/SoVRMLCoordinate.h>
#include <Inventor/VRMLnodes/SoVRMLCylinder.h>
#include <Inventor/VRMLnodes/SoVRMLElevationGrid.h>
#include <Inventor/VRMLnodes/SoVRMLIndexedFaceSet.h>
#include <Inventor/VRMLnodes/SoVRMLIndexedLineSet.h>
#include <Inventor/VRMLnodes/SoVRMLInline.h>
#include <Inventor/VRMLnodes/SoVRMLLOD.h>
#include <Inventor/VRMLnodes/SoVRMLPointSet.h>
#include <Inventor/VRMLnodes/SoVRMLSphere.h>
#include <Inventor/VRMLnodes/SoVRMLSwitch.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/errors/SoDebugError.h>
#include <Inventor/errors/SoMemoryError.h>
#include <Inventor/errors/SoReadError.h>
#include <Inventor/misc/SoChildList.h>
#include <Inventor/misc/SoState.h>
#include <Inventor/nodes/SoArray.h>
#include <Inventor/nodes/SoCone.h>
#include <Inventor/nodes/SoCylinder.h>
#include <Inventor/nodes/SoDrawStyle.h>
#include <Inventor/nodes/SoFaceSet.h>
#include <Inventor/nodes/SoFile.h>
#include <Inventor/nodes/SoImage.h>
#include <Inventor/nodes/SoIndexedFaceSet.h>
#include <Inventor/nodes/SoIndexedLineSet.h>
#include <Inventor/nodes/SoIndexedNurbsCurve.h>
#include <Inventor/nodes/SoIndexedNurbsSurface.h>
#include <Inventor/nodes/SoIndexedPointSet.h>
#include <Inventor/nodes/SoIndexedTriangleStripSet.h>
#include <Inventor/nodes/SoLOD.h>
#include <Inventor/nodes/SoLevelOfDetail.h>
#include <Inventor/nodes/SoLineSet.h>
#include <Inventor/nodes/SoMultipleCopy.h>
#include <Inventor/nodes/SoNurbsCurve.h>
#include <Inventor/nodes/SoNurbsSurface.h>
#include <Inventor/nodes/SoPointSet.h>
#include <Inventor/nodes/SoQuadMesh.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>
#include <Inventor/nodes/SoSphere.h>
#include <Inventor/nodes/SoSwitch.h>
#include <Inventor/nodes/SoText2.h>
#include <Inventor/nodes/SoTriangleStripSet.h>
#include <Inventor/nodes/SoVertexProperty.h>
#include <Inventor/nodes/SoWWWInline.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/importer/unpacked.h"
#include "common/importer/vrml_protos.h"
#include "common/mesh/text_scan.h"
#include "common/mesh/tri_mesh.h"
#include "common/text/plain_text.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

/// Deepest nesting of braces in a text file: Coin reads and walks by recursion, about a kilobyte of stack a level. Real
/// models nest below 50.
constexpr int kDeepestNesting = 500;

constexpr std::string_view kBetweenWords = " \t\r\n,[]{}\"#";

/// Messages of Coin while it reads a file, which would go to stderr: the first one, and the last of what it cannot read, at
/// which it ends. That a picture is missing ends nothing.
struct Said {
  std::string first, last;

  /// "line 2: Unknown field ..." of "Coin read error: Unknown field ...\n\tOccurred at line   2 in ...".
  [[nodiscard]] std::string text() const {
    std::string text = last.empty() ? first : last;
    std::string line;
    constexpr std::string_view kHead = "Coin read error: ", kPlace = "Occurred at line";
    if (text.starts_with(kHead)) text.erase(0, kHead.size());
    if (const std::size_t place = text.find(kPlace); place != text.npos) {
      const std::size_t digits = text.find_first_of("0123456789", place);
      if (digits != text.npos) line = text.substr(digits, text.find_first_not_of("0123456789", digits) - digits);
      text.resize(place);
    }
    std::erase(text, '\t');
    std::ranges::replace(text, '\n', ' ');
    while (text.ends_with(' ')) text.pop_back();
    constexpr std::size_t kMaxSaid = 200;
    if (text.empty()) return {};
    return (line.empty() ? ": " : " at line " + line + ": ") + "Coin says \"" + printable(text.substr(0, kMaxSaid)) +
           '"';
  }
};
Said& said() {
  static Said all;
  return all;
}

/// Each character of a text that is in no comment and no quotes.
template <class Take>
void eachPlain(std::string_view text, const Take& take) {
  bool quote = false, comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (comment) {
      comment = c != '\n' && c != '\r';
    } else if (quote) {
      if (c == '\\') ++i;
      quote = c != '"';
    } else if (c == '"') {
      quote = true;
    } else if (c == '#') {
      comment = true;
    } else {
      take(i);
    }
  }
}

/// Braces and brackets within one another, and those that are open at the end.
struct Nesting {
  int deepest = 0, open = 0;
};
Nesting nestingOf(std::string_view text) {
  Nesting nesting;
  eachPlain(text, [&](std::size_t i) {
    const char c = text[i];
    if (c == '{' || c == '[') nesting.deepest = std::max(nesting.deepest, ++nesting.open);
    if (c == '}' || c == ']') --nesting.open;
  });
  return nesting;
}
int deepestNesting(std::string_view text) { return nestingOf(text).deepest; }

/// Whether the first line says so.
bool isBinary(std::string_view text) { return text.substr(0, text.find('\n')).find("binary") != text.npos; }

/// Coin takes a number that float32 does not hold for another.
Result<void> checkNumbers(std::string_view text) {
  if (isBinary(text)) return {};
  constexpr std::string_view kInWord = "+-.0123456789eE";
  std::size_t end = 0;
  std::string fault;
  eachPlain(text, [&](std::size_t i) {
    const bool isDigit = text[i] >= '0' && text[i] <= '9';
    if (i < end || !fault.empty()) return;
    if (!isDigit && (text[i] != '.' && text[i] != '-' && text[i] != '+')) {
      if (kBetweenWords.find(text[i]) == kBetweenWords.npos)
        end = std::min(text.find_first_of(kBetweenWords, i), text.size());  // a name
      return;
    }
    end = std::min(text.find_first_not_of(kInWord, i), text.size());
    const std::string_view word = text.substr(i, end - i);
    double value = 0;
    const auto [last, error] =
        std::from_chars(word.data() + (word[0] == '+' ? 1 : 0), word.data() + word.size(), value);
    const bool isTooLarge = error == std::errc::result_out_of_range
                                ? word.find("e-") == word.npos && word.find("E-") == word.npos
                                : std::abs(value) > static_cast<double>(std::numeric_limits<float>::max());
    if (!isTooLarge) return;
    fault = "has the number " + inQuotes(word) + " at line " +
            std::to_string(1 + std::ranges::count(text.substr(0, i), '\n')) + ", which float32 does not hold";
  });
  if (fault.empty()) return {};
  return refused("", fault);
}

/// Without a byte order mark and blanks before the head.
std::string plain(std::string_view file) {
  if (file.starts_with("\xef\xbb\xbf")) file.remove_prefix(3);
  const std::size_t head = file.find_first_not_of(" \t\r\n");
  if (head != std::string_view::npos && file[head] == '#') file.remove_prefix(head);
  std::string text(file);
  constexpr std::string_view kVrml = "#VRML V2.0 utf8";
  if (inLowerCase(text.substr(0, kVrml.size())) == inLowerCase(kVrml)) text.replace(0, kVrml.size(), kVrml);
  return text;
}

/// The result of fopen() while Coin opens a file that it may include; null: none.
const std::string*& handedOver() {
  static const std::string* bytes = nullptr;
  return bytes;
}
bool& opensFiles() {
  static bool itself = true;
  return itself;
}

/// The files that a file includes.
struct Included {
  const IncludeReader& read;
  std::deque<std::string> files = {};               ///< Coin reads them where they are.
  std::map<std::string, SoSeparator*> scenes = {};  ///< Of Inlines, by path; null: none, or it is being read.
  std::vector<std::string> missing = {};            ///< Names; of each a part is left out.
  std::size_t bytes = 0;

  /// Null: it is not there, or nests more levels than `deepest`.
  std::string* take(const std::string& name, int deepest) {
    const auto file = read(name);
    const Result<std::string> text = file ? unpacked(*file).map(plain) : refused("", "is not there");
    if (!text || deepestNesting(*text) > deepest || !checkNumbers(*text)) return nullptr;
    bytes += text->size();
    return &files.emplace_back(*text);
  }
};

/// Lets a file include what the reader gives.
class ConfinedInput final : public SoInput {
 public:
  explicit ConfinedInput(Included& included) : included_(included) {}

  SbBool pushFile(const char* name) override {
    if (const std::string* const text = included_.take(name, kDeepestNesting)) {
      handedOver() = text;
      const SbBool pushed = SoInput::pushFile((std::string("/") + name).c_str());  // as no path to be searched for
      handedOver() = nullptr;
      return pushed;
    }
    return FALSE;
  }

 private:
  Included& included_;
};

/// Null: it cannot be read. @param text  Afterwards, as Coin reads it.
SoSeparator* read(std::string& text, Included& included) {
  if (text.starts_with("#VRML V2")) {
    auto protos =
        withProtosThatAreThere(text, [&](const std::string& name) { return included.read(name).has_value(); });
    std::ranges::move(protos.missing, std::back_inserter(included.missing));
    text = std::move(protos.text);
  }
  ConfinedInput input(included);
  input.setBuffer(text.data(), text.size());
  return input.isValidBuffer() ? SoDB::readAll(&input) : nullptr;
}

/// Whose file is not there, or cannot be read.
bool isEmptyFile(const SoNode& node) {
  return node.isOfType(SoFile::getClassTypeId()) && node.getChildren()->getLength() == 0;
}

/// The names in an Inline of VRML, in the order in which they are tried; none: it is none.
std::vector<std::string> namesOf(const SoNode& node) {
  std::vector<std::string> names;
  if (node.isOfType(SoWWWInline::getClassTypeId())) {
    names.emplace_back(static_cast<const SoWWWInline&>(node).name.getValue().getString());
  } else if (node.isOfType(SoVRMLInline::getClassTypeId())) {
    const SoMFString& url = static_cast<const SoVRMLInline&>(node).url;
    for (int i = 0; i < url.getNum(); ++i) names.emplace_back(url[i].getString());
  }
  return names;
}

/// Puts into Inlines of VRML what they show, by the first name that is a file's. Coin looks for it beside no file, and under one
/// name.
/// @param folder  In which the root was read; @param deepest  Levels of what is put in.
void fillInlines(SoNode& root, const std::filesystem::path& folder, int deepest, Included& included) {
  std::set<const SoNode*> seen;
  for (std::vector<SoNode*> left{&root}; !left.empty();) {
    SoNode& node = *left.back();
    left.pop_back();
    if (!seen.insert(&node).second) continue;
    const SoChildList* const children = node.getChildren();
    for (int i = 0; children != nullptr && i < children->getLength(); ++i) left.push_back((*children)[i]);
    if (isEmptyFile(node)) included.missing.emplace_back(static_cast<SoFile&>(node).name.getValue().getString());
    const auto names = namesOf(node);
    SoSeparator* filled = nullptr;
    for (std::string name : names) {
      name.resize(std::min(name.find('#'), name.size()));
      if (name.empty() || name.find("://") != name.npos) continue;
      const std::filesystem::path path = (folder / name).lexically_normal();
      const auto [scene, isNew] = included.scenes.try_emplace(path.string());
      std::string* const text = isNew ? included.take(path.string(), deepest) : nullptr;
      if (SoSeparator* const own = text != nullptr ? read(*text, included) : nullptr) {
        own->ref();
        fillInlines(*own, path.parent_path(), deepest - deepestNesting(*text) - 1, included);
        scene->second = own;
      }
      filled = scene->second;
      if (filled == nullptr) continue;
      if (node.isOfType(SoWWWInline::getClassTypeId())) {
        static_cast<SoWWWInline&>(node).setChildData(filled);
      } else {
        static_cast<SoVRMLInline&>(node).setChildData(filled);
      }
      break;
    }
    if (!names.empty() && filled == nullptr) included.missing.push_back(names.front());
  }
}

struct Gathering {
  PolygonSoup found;
  std::set<const SoNode*> shown = {};     // shapes
  bool isRound = false;                   // the shape that is walked is one that Coin makes
  std::vector<Vec3> cornersOfRound = {};  // in its own frame, the last of `found`
  std::size_t maxTriangles = 0;
  std::string fault = {};  // ends the walk

  [[nodiscard]] bool hasRoom() {
    if (found.triangles.size() < maxTriangles) return true;
    fault = "makes more than " + std::to_string(maxTriangles) + " triangles by repeating shapes or by round ones";
    return false;
  }
};

void append(PolygonSoup& soup, const SbMatrix& toRoot, const SbVec3f& point) {
  Vec3 at;
  for (int i = 0; i < 3; ++i) {
    double sum = toRoot[3][i];
    for (int k = 0; k < 3; ++k) sum += static_cast<double>(point[k]) * static_cast<double>(toRoot[k][i]);
    at[i] = sum;
  }
  double local = 0, placed = 0, times = 0;
  for (int i = 0; i < 3; ++i) {
    local = std::max(local, std::abs(static_cast<double>(point[i])));
    placed = std::max(placed, std::abs(static_cast<double>(toRoot[3][i])));
    times =
        std::max(times, static_cast<double>(std::abs(toRoot[0][i]) + std::abs(toRoot[1][i]) + std::abs(toRoot[2][i])));
  }
  soup.rounding = std::max(soup.rounding, float32Rounding(local) * times + float32Rounding(placed));
  double w = toRoot[3][3];
  for (int k = 0; k < 3; ++k) w += static_cast<double>(point[k]) * static_cast<double>(toRoot[k][3]);
  soup.vertices.push_back(at / w);
}

void takeTriangle(void* data, SoCallbackAction* action, const SoPrimitiveVertex* a, const SoPrimitiveVertex* b,
                  const SoPrimitiveVertex* c) {
  auto& gathering = *static_cast<Gathering*>(data);
  PolygonSoup& found = gathering.found;
  if (!gathering.fault.empty() || !gathering.hasRoom()) return;
  const SbMatrix& toRoot = action->getModelMatrix();
  // Vertices run clockwise where the file says so, and where a mirroring transform turns them round.
  const bool clockwise = action->getVertexOrdering() == SoShapeHints::CLOCKWISE;
  if (clockwise != (toRoot.det3() < 0)) std::swap(b, c);
  for (const SoPrimitiveVertex* vertex : {a, b, c}) {
    const SbVec3f& at = vertex->getPoint();
    append(found, toRoot, at);
    if (gathering.isRound) gathering.cornersOfRound.emplace_back(at[0], at[1], at[2]);
  }
  const auto end = static_cast<std::uint32_t>(found.vertices.size());
  found.triangles.push_back({end - 3, end - 2, end - 1});
}

/// Coin makes the ends of a circle by sums of angles in float32, which end beside where they began: the seam would stay open.
void closeSeam(PolygonSoup& soup, const std::vector<Vec3>& corners) {
  constexpr double kSeam = 0x1p-14;  // of the largest coordinate; its smallest triangles are 300 times as large
  double largest = 0;
  for (const Vec3& corner : corners)
    largest = std::max({largest, std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
  const std::size_t first = soup.vertices.size() - corners.size();
  const auto alongLine = [&](std::size_t i) { return glm::dot(corners[i], Vec3(0.62, 0.53, 0.58)); };
  std::vector<std::size_t> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, alongLine);
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t k = i; k-- > 0 && alongLine(order[i]) - alongLine(order[k]) <= kSeam * largest;) {
      if (glm::distance(corners[order[i]], corners[order[k]]) > kSeam * largest) continue;
      soup.vertices[first + order[i]] = soup.vertices[first + order[k]];
      break;
    }
  }
}

SoCallbackAction::Response beginRound(void* data, SoCallbackAction*, const SoNode*) {
  auto& gathering = *static_cast<Gathering*>(data);
  gathering.isRound = true;
  gathering.cornersOfRound.clear();
  return SoCallbackAction::CONTINUE;
}

SoCallbackAction::Response endRound(void* data, SoCallbackAction*, const SoNode*) {
  auto& gathering = *static_cast<Gathering*>(data);
  gathering.isRound = false;
  closeSeam(gathering.found, gathering.cornersOfRound);
  return SoCallbackAction::CONTINUE;
}

/// Before a shape is walked.
SoCallbackAction::Response leaveInvisibleOut(void* data, SoCallbackAction* action, const SoNode* node) {
  auto& gathering = *static_cast<Gathering*>(data);
  gathering.shown.insert(node);
  if (action->getDrawStyle() != SoDrawStyle::INVISIBLE) return SoCallbackAction::CONTINUE;
  ++gathering.found.leftOut.unshown;
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response skip(void* data, SoCallbackAction*, const SoNode*) {
  ++static_cast<Gathering*>(data)->found.shapesSkipped;
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response countUnknown(void* data, SoCallbackAction*, const SoNode* node) {
  const SoChildList* children = node->getChildren();  // what the file says to use instead
  if (children == nullptr || children->getLength() == 0) ++static_cast<Gathering*>(data)->found.shapesSkipped;
  return SoCallbackAction::CONTINUE;
}

SoCallbackAction::Response stopAtFault(void* data, SoCallbackAction*, const SoNode*) {
  return static_cast<Gathering*>(data)->fault.empty() ? SoCallbackAction::CONTINUE : SoCallbackAction::ABORT;
}

/// A shape's faces, which are taken by the points that they name: Coin does not look whether those are there, stops at a
/// face of fewer than three corners, and looks up normals and colours, which cannot be felt, by indices of theirs.
class Faces {
 public:
  Faces(Gathering& gathering, const SoCallbackAction& action, const SoMFVec3f* own, bool clockwise)
      : gathering_(gathering),
        action_(action),
        toRoot_(action.getModelMatrix()),
        own_(own),
        count_(own != nullptr ? own->getNum() : action.getNumCoordinates()),
        turned_(clockwise != (toRoot_.det3() < 0)) {}

  [[nodiscard]] std::int64_t count() const { return count_; }

  void add(std::vector<std::int64_t> face) {
    if (!gathering_.fault.empty() || !gathering_.hasRoom()) return;
    if (turned_ && !face.empty()) std::reverse(face.begin() + 1, face.end());
    std::vector<std::uint32_t> corners;
    for (const std::int64_t point : face) {
      if (point < 0 || point >= count_) {
        refuse("names point " + std::to_string(point));
        return;
      }
      const int i = static_cast<int>(point);
      corners.push_back(static_cast<std::uint32_t>(gathering_.found.vertices.size()));
      append(gathering_.found, toRoot_, own_ != nullptr ? (*own_)[i] : action_.getCoordinate3(i));
    }
    gathering_.found.addPolygon(corners);
  }
  /// Every second triangle of a strip is turned round.
  void addStrip(const std::vector<std::int64_t>& strip) {
    if (strip.size() < 3) ++gathering_.found.degenerate;
    for (std::size_t i = 2; i < strip.size() && gathering_.fault.empty(); ++i) {
      add(i % 2 == 0 ? std::vector{strip[i - 2], strip[i - 1], strip[i]}
                     : std::vector{strip[i - 1], strip[i - 2], strip[i]});
    }
  }
  void refuse(const std::string& what) {
    gathering_.fault = "a shape " + what + " of " + std::to_string(count_) + "; count from 0";
  }

 private:
  Gathering& gathering_;
  const SoCallbackAction& action_;
  const SbMatrix toRoot_;
  const SoMFVec3f* own_;
  std::int64_t count_;
  bool turned_;
};

Faces facesOf(Gathering& gathering, const SoCallbackAction& action, const SoVertexShape& shape) {
  const auto* own = static_cast<const SoVertexProperty*>(shape.vertexProperty.getValue());
  return {gathering, action, own != nullptr && own->vertex.getNum() > 0 ? &own->vertex : nullptr,
          action.getVertexOrdering() == SoShapeHints::CLOCKWISE};
}

/// Runs of indices that end with a negative one, or with the last.
template <typename Take>
void eachRun(const SoMFInt32& indices, const Take& take) {
  std::vector<std::int64_t> run;
  for (int i = 0; i < indices.getNum(); ++i) {
    if (indices[i] >= 0) {
      run.push_back(indices[i]);
    } else {
      take(run);
      run.clear();
    }
  }
  if (!run.empty()) take(run);
}

/// Runs of points that follow one another.
template <typename Take>
void eachRun(Faces& faces, const SoMFInt32& lengths, std::int64_t first, const Take& take) {
  for (int i = 0; i < lengths.getNum(); ++i) {
    const std::int64_t length = lengths[i] == -1 ? std::max<std::int64_t>(0, faces.count() - first) : lengths[i];
    if (first < 0 || length < 0 || first + length > faces.count()) {
      faces.refuse("asks for " + std::to_string(lengths[i]) + " points from point " + std::to_string(first));
      return;
    }
    std::vector<std::int64_t> run(static_cast<std::size_t>(length));
    std::iota(run.begin(), run.end(), first);
    take(run);
    first += length;
  }
}

SoCallbackAction::Response takeIndexedFaces(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoIndexedFaceSet&>(*node);
  Faces faces = facesOf(*static_cast<Gathering*>(data), *action, shape);
  eachRun(shape.coordIndex, [&](const auto& face) { faces.add(face); });
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response takeIndexedStrips(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoIndexedTriangleStripSet&>(*node);
  Faces faces = facesOf(*static_cast<Gathering*>(data), *action, shape);
  eachRun(shape.coordIndex, [&](const auto& strip) { faces.addStrip(strip); });
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response takeFaces(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoFaceSet&>(*node);
  Faces faces = facesOf(*static_cast<Gathering*>(data), *action, shape);
  eachRun(faces, shape.numVertices, shape.startIndex.getValue(), [&](const auto& face) { faces.add(face); });
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response takeStrips(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoTriangleStripSet&>(*node);
  Faces faces = facesOf(*static_cast<Gathering*>(data), *action, shape);
  eachRun(faces, shape.numVertices, shape.startIndex.getValue(), [&](const auto& strip) { faces.addStrip(strip); });
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response takeQuads(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoQuadMesh&>(*node);
  Faces faces = facesOf(*static_cast<Gathering*>(data), *action, shape);
  const std::int64_t first = shape.startIndex.getValue();
  const std::int64_t across = shape.verticesPerRow.getValue(), along = shape.verticesPerColumn.getValue();
  if (first < 0 || across < 0 || along < 0 || first + across * along > faces.count()) {
    faces.refuse("asks for " + std::to_string(along) + " rows of " + std::to_string(across) + " points from point " +
                 std::to_string(first));
    return SoCallbackAction::PRUNE;
  }
  for (std::int64_t row = 0; row + 1 < along; ++row) {
    for (std::int64_t i = 0; i + 1 < across; ++i) {
      const std::int64_t at = first + row * across + i;
      faces.add({at, at + across, at + across + 1, at + 1});
    }
  }
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response takeVrmlFaces(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoVRMLIndexedFaceSet&>(*node);
  const SoNode* points = shape.coord.getValue();
  static const SoMFVec3f none;
  const bool isThere = points != nullptr && points->isOfType(SoVRMLCoordinate::getClassTypeId());
  if (points != nullptr && !isThere) return skip(data, action, node);  // of a prototype
  Faces faces(*static_cast<Gathering*>(data), *action,
              isThere ? &static_cast<const SoVRMLCoordinate*>(points)->point : &none, shape.ccw.getValue() == FALSE);
  eachRun(shape.coordIndex, [&](const auto& face) { faces.add(face); });
  return SoCallbackAction::PRUNE;
}

/// By its heights, which Coin does not count; nor does it look at ccw.
SoCallbackAction::Response takeElevations(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& grid = static_cast<const SoVRMLElevationGrid&>(*node);
  auto& gathering = *static_cast<Gathering*>(data);
  const std::int64_t x = grid.xDimension.getValue(), z = grid.zDimension.getValue();
  if (x < 0 || z < 0 || (x > 0 && z > grid.height.getNum() / x)) {
    gathering.fault = "an ElevationGrid asks for " + std::to_string(x) + " times " + std::to_string(z) +
                      " heights of " + std::to_string(grid.height.getNum());
    return SoCallbackAction::ABORT;
  }
  SoMFVec3f points;
  points.setNum(static_cast<int>(x * z));
  for (int i = 0; i < points.getNum(); ++i) {
    const auto column = static_cast<float>(i % x), row = static_cast<float>(i / x);
    points.set1Value(i, column * grid.xSpacing.getValue(), grid.height[i], row * grid.zSpacing.getValue());
  }
  Faces faces(gathering, *action, &points, grid.ccw.getValue() == FALSE);
  for (std::int64_t row = 1; row < z; ++row) {
    for (std::int64_t i = 1; i < x; ++i) {
      const std::int64_t at = row * x + i;
      faces.add({at - x - 1, at - 1, at, at - x});
    }
  }
  return SoCallbackAction::PRUNE;
}

/// What it takes to walk a graph: nodes that are come to, those that several lead to as often.
class Walk {
 public:
  /// Why it is not to be walked; empty: it may be.
  [[nodiscard]] std::string fault(const SoNode& root, std::size_t most) {
    const double nodes = below(root, 0).nodes;
    if (!fault_.empty() || nodes <= static_cast<double>(most)) return fault_;
    return "leads to more than " + std::to_string(most) + " nodes by repeating them (USE, Array, MultipleCopy)";
  }
  /// Shapes that are somewhere, and not among these; each once.
  [[nodiscard]] std::uint64_t shapesBeside(const std::set<const SoNode*>& shown) const {
    return static_cast<std::uint64_t>(std::ranges::count_if(known_, [&](const auto& known) {
      return known.first->isOfType(SoShape::getClassTypeId()) && !shown.contains(known.first);
    }));
  }

 private:
  struct Below {
    double nodes = 0;
    int levels = 0;  ///< 0: not known yet.
  };

  Below below(const SoNode& node, int depth) {
    const auto [known, isNew] = known_.try_emplace(&node);
    if (!isNew && known->second.levels == 0) fault_ = "uses a node within itself";
    if (depth + known->second.levels > kDeepestNesting) {
      fault_ = "nests more than " + std::to_string(kDeepestNesting) + " levels deep";
    }
    if (!isNew || !fault_.empty()) return known->second;
    double sum = 0, largest = 0;
    int levels = 0;
    const SoChildList* children = node.getChildren();
    for (int i = 0; children != nullptr && i < children->getLength() && fault_.empty(); ++i) {
      const Below child = below(*(*children)[i], depth + 1);
      sum += child.nodes;
      largest = std::max(largest, child.nodes);
      levels = std::max(levels, child.levels);
    }
    return known_[&node] = {1 + times(node) * (isChoice(node) ? largest : sum), levels + 1};
  }

  static bool isChoice(const SoNode& node) {
    if (node.isOfType(SoSwitch::getClassTypeId())) {
      return static_cast<const SoSwitch&>(node).whichChild.getValue() != SO_SWITCH_ALL;
    }
    return node.isOfType(SoLOD::getClassTypeId()) || node.isOfType(SoLevelOfDetail::getClassTypeId()) ||
           node.isOfType(SoVRMLLOD::getClassTypeId()) || node.isOfType(SoVRMLSwitch::getClassTypeId());
  }

  static double times(const SoNode& node) {
    if (node.isOfType(SoMultipleCopy::getClassTypeId())) {
      return static_cast<const SoMultipleCopy&>(node).matrix.getNum();
    }
    if (!node.isOfType(SoArray::getClassTypeId())) return 1;
    const auto& array = static_cast<const SoArray&>(node);
    return 1.0 * array.numElements1.getValue() * array.numElements2.getValue() * array.numElements3.getValue();
  }

  std::map<const SoNode*, Below> known_;
  std::string fault_;
};

/// As it stands: Coin turns it towards somebody who looks from the front, out of what its parents turn.
SoCallbackAction::Response takeBillboard(void* /*gathering*/, SoCallbackAction* action, const SoNode* node) {
  action->getState()->push();
  node->getChildren()->traverse(action);
  action->getState()->pop();
  return SoCallbackAction::PRUNE;
}

/// The finest level: Coin takes one by the distance from the origin.
SoCallbackAction::Response takeFinest(void* /*gathering*/, SoCallbackAction* action, const SoNode* node) {
  const bool isOfVrml = node->isOfType(SoVRMLLOD::getClassTypeId());  // what else is in it holds for what follows, too
  if (isOfVrml) action->getState()->push();
  if (node->getChildren()->getLength() > 0) node->getChildren()->traverse(action, 0);
  if (isOfVrml) action->getState()->pop();
  return SoCallbackAction::PRUNE;
}

void gather(SoNode* root, Gathering& gathering) {
  SoCallbackAction action;
  action.addTriangleCallback(SoShape::getClassTypeId(), takeTriangle, &gathering);
  action.addPreCallback(SoNode::getClassTypeId(), stopAtFault, &gathering);
  action.addPreCallback(SoShape::getClassTypeId(), leaveInvisibleOut, &gathering);
  for (const SoType type :
       {SoSphere::getClassTypeId(), SoCone::getClassTypeId(), SoCylinder::getClassTypeId(),
        SoVRMLSphere::getClassTypeId(), SoVRMLCone::getClassTypeId(), SoVRMLCylinder::getClassTypeId()}) {
    action.addPreCallback(type, beginRound, &gathering);
    action.addPostCallback(type, endRound, &gathering);
  }
  for (const SoType type :
       {SoNurbsSurface::getClassTypeId(), SoIndexedNurbsSurface::getClassTypeId(), SoNurbsCurve::getClassTypeId(),
        SoIndexedNurbsCurve::getClassTypeId(), SoLineSet::getClassTypeId(), SoIndexedLineSet::getClassTypeId(),
        SoPointSet::getClassTypeId(), SoIndexedPointSet::getClassTypeId(), SoVRMLIndexedLineSet::getClassTypeId(),
        SoVRMLPointSet::getClassTypeId(), SoText2::getClassTypeId(), SoImage::getClassTypeId()}) {
    action.addPreCallback(type, skip, &gathering);
  }
  action.addPreCallback(SoType::fromName("UnknownNode"), countUnknown, &gathering);
  action.addPreCallback(SoVRMLBillboard::getClassTypeId(), takeBillboard, &gathering);
  for (const SoType type : {SoLOD::getClassTypeId(), SoLevelOfDetail::getClassTypeId(), SoVRMLLOD::getClassTypeId()}) {
    action.addPreCallback(type, takeFinest, &gathering);
  }
  action.addPreCallback(SoIndexedFaceSet::getClassTypeId(), takeIndexedFaces, &gathering);
  action.addPreCallback(SoIndexedTriangleStripSet::getClassTypeId(), takeIndexedStrips, &gathering);
  action.addPreCallback(SoFaceSet::getClassTypeId(), takeFaces, &gathering);
  action.addPreCallback(SoTriangleStripSet::getClassTypeId(), takeStrips, &gathering);
  action.addPreCallback(SoQuadMesh::getClassTypeId(), takeQuads, &gathering);
  action.addPreCallback(SoVRMLIndexedFaceSet::getClassTypeId(), takeVrmlFaces, &gathering);
  action.addPreCallback(SoVRMLElevationGrid::getClassTypeId(), takeElevations, &gathering);
  action.apply(root);
}

/// Whether a text in Open Inventor or VRML has its first line; binary files have one, too.
bool hasHead(std::string_view file) { return file.starts_with("#Inventor V") || file.starts_with("#VRML V"); }

std::string listOf(const std::vector<std::string>& names) {
  constexpr std::size_t kMax = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMax); ++i) list += (i > 0 ? ", " : "") + inQuotes(names[i]);
  return list + (names.size() > kMax ? " and " + std::to_string(names.size() - kMax) + " more" : "");
}

Error notRead(const std::string& file) {
  const std::string line =
      printable(std::string_view(file).substr(0, std::min(file.find_first_of("\r\n"), std::size_t{40})));
  if (!hasHead(file)) {
    return {"", "begins with \"" + line +
                    "\"; the first line of Open Inventor and VRML is \"#Inventor V2.1 ascii\" or \"#VRML V2.0 utf8\""};
  }
  if (file.starts_with("#VRML V") && !file.starts_with("#VRML V1.0") && !file.starts_with("#VRML V2.0"))
    return {"", "is VRML of another version, \"" + line + "\"; V1.0 and V2.0 (VRML 97) are read"};
  if (const int open = nestingOf(file).open; open > 0 && !isBinary(file)) {
    return {"", "is cut off or damaged: at its end " + std::to_string(open) + " braces or brackets are open" +
                    said().text()};
  }
  return {"", "cannot be read as Open Inventor" + said().text()};
}

}  // namespace

void startInventor() {
  const auto keep = [](const SoError* error, void*) {
    const std::string text = error->getDebugString().getString();
    if (said().first.empty()) said().first = text;
    if (error->isOfType(SoReadError::getClassTypeId()) && text.find("texture") == text.npos) said().last = text;
  };
  SoDB::init();
  SoInteraction::init();
  SoVRMLInline::setReadAsSoFile(FALSE);
  SoError::setHandlerCallback(keep, nullptr);
  SoDebugError::setHandlerCallback(keep, nullptr);
  SoReadError::setHandlerCallback(keep, nullptr);
  SoMemoryError::setHandlerCallback(keep, nullptr);
}

Result<PolygonSoup> gatherInventor(std::string_view bytes, const IncludeReader& readIncluded) {
  opensFiles() = false;
  if (const auto text = plainText(bytes); !text) return tl::unexpected(text.error());
  std::string file = plain(bytes);
  if (deepestNesting(file) > kDeepestNesting) {
    return refused("", "nests more than " + std::to_string(kDeepestNesting) + " levels deep");
  }
  if (auto ok = checkNumbers(file); !ok) return tl::unexpected(std::move(ok).error());
  Included included{readIncluded};
  SoSeparator* root = read(file, included);
  if (root == nullptr) return tl::unexpected(notRead(file));
  root->ref();
  fillInlines(*root, {}, kDeepestNesting - deepestNesting(file), included);
  const std::size_t most = kMaxOfFewBytes + file.size() + included.bytes;
  Gathering gathering{.found = {}, .maxTriangles = std::min<std::size_t>(kMaxTriangles, most)};
  gathering.found.shapesSkipped = included.missing.size();
  Walk walk;
  gathering.fault = walk.fault(*root, most);
  if (gathering.fault.empty()) gather(root, gathering);
  gathering.found.leftOut.unshown += walk.shapesBeside(gathering.shown);
  root->unref();
  if (!gathering.fault.empty()) return refused("", gathering.fault);
  PolygonSoup& found = gathering.found;
  if (found.triangles.empty() && !included.missing.empty() && found.shapesSkipped == included.missing.size())
    return refused("", "holds nothing but what is in files that cannot be read, or are not in its folder or below: " +
                           listOf(included.missing));
  if (found.triangles.empty() && found.degenerate + found.shapesSkipped == 0 && !hasHead(file))
    return tl::unexpected(notRead(file));
  if (nestingOf(file).open > 0 && !isBinary(file)) found.cutOff = notRead(file).reason;
  return std::move(found);
}

}  // namespace haptics

// Instead of libc's: Coin names the files that it reads, and this program may open none.

extern "C" [[gnu::visibility("default")]] std::FILE* fopen(const char* name, const char* mode) {
  using namespace haptics;
  if (opensFiles()) {
    const int file = open(name, O_RDONLY | O_CLOEXEC);
    return file < 0 ? nullptr : fdopen(file, mode);
  }
  if (const std::string* bytes = handedOver()) return fmemopen(const_cast<char*>(bytes->data()), bytes->size(), "r");
  errno = EACCES;
  return nullptr;
}

extern "C" [[gnu::visibility("default")]] int stat(const char* name, struct stat* status) {
  using namespace haptics;
  if (opensFiles()) return fstatat(AT_FDCWD, name, status, 0);
  errno = EACCES;
  if (handedOver() == nullptr) return -1;
  *status = {};
  status->st_mode = S_IFREG;
  return 0;
}
