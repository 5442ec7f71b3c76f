#include "common/mesh/inventor_reader.h"

#include <Inventor/SbMatrix.h>
#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoInteraction.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/errors/SoDebugError.h>
#include <Inventor/errors/SoMemoryError.h>
#include <Inventor/errors/SoReadError.h>
#include <Inventor/nodes/SoIndexedNurbsCurve.h>
#include <Inventor/nodes/SoIndexedNurbsSurface.h>
#include <Inventor/nodes/SoNurbsCurve.h>
#include <Inventor/nodes/SoNurbsSurface.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "common/mesh/file_bytes.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

/// Deepest nesting of braces in a text file: Coin reads and walks by recursion, about a kilobyte of stack a level. Real
/// models nest below 50.
constexpr int kDeepestNesting = 500;

/// Most files that one file may include, directly or not; ends a file that includes itself. The largest model known
/// includes 12.
constexpr int kMostIncludes = 100;

/// What Coin says while a file is read; it would go to stderr.
std::string& said() {
  static std::string text;
  return text;
}

void startCoin() {
  const auto keep = [](const SoError* error, void*) {
    if (said().empty()) said() = error->getDebugString().getString();
  };
  SoDB::init();
  SoInteraction::init();
  std::atexit(SoDB::finish);
  SoError::setHandlerCallback(keep, nullptr);
  SoDebugError::setHandlerCallback(keep, nullptr);
  SoReadError::setHandlerCallback(keep, nullptr);
  SoMemoryError::setHandlerCallback(keep, nullptr);
}

int deepestNesting(std::string_view text) {
  int depth = 0, deepest = 0;
  bool quote = false, comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (comment) {
      comment = c != '\n';
    } else if (quote) {
      if (c == '\\') ++i;
      quote = c != '"';
    } else if (c == '"') {
      quote = true;
    } else if (c == '#') {
      comment = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

/// Lets a file include others from its own folder and below only.
class ConfinedInput final : public SoInput {
 public:
  explicit ConfinedInput(const std::filesystem::path& folder) : folder_(folder) {}

  [[nodiscard]] std::uint64_t leftOut() const { return leftOut_; }

  SbBool pushFile(const char* name) override {
    if (const auto path = allowed(name); path && SoInput::pushFile(path->c_str())) return TRUE;
    ++leftOut_;
    return FALSE;
  }

 private:
  [[nodiscard]] std::optional<std::filesystem::path> allowed(const std::filesystem::path& name) {
    const auto goesUp = [](const std::filesystem::path& part) { return part == ".."; };
    if (name.is_absolute() || std::any_of(name.begin(), name.end(), goesUp) || ++included_ > kMostIncludes) {
      return std::nullopt;
    }
    const auto content = readFile(folder_ / name);
    if (!content || deepestNesting(*content) > kDeepestNesting) return std::nullopt;
    return folder_ / name;
  }

  std::filesystem::path folder_;
  int included_ = 0;
  std::uint64_t leftOut_ = 0;
};

struct Gathering {
  PolygonSoup soup;
  bool tooMany = false;
};

void takeTriangle(void* data, SoCallbackAction* action, const SoPrimitiveVertex* a, const SoPrimitiveVertex* b,
                  const SoPrimitiveVertex* c) {
  auto& [soup, tooMany] = *static_cast<Gathering*>(data);
  if (soup.triangles.size() >= kMaxTriangles) {
    tooMany = true;
    return;
  }
  const SbMatrix& toRoot = action->getModelMatrix();
  const auto first = static_cast<std::uint32_t>(soup.vertices.size());
  for (const SoPrimitiveVertex* vertex : {a, b, c}) {
    SbVec3f point;
    toRoot.multVecMatrix(vertex->getPoint(), point);
    soup.vertices.emplace_back(point[0], point[1], point[2]);
  }
  // Vertices run clockwise where the file says so, and where a mirroring transform turns them round.
  const bool clockwise = action->getVertexOrdering() == SoShapeHints::CLOCKWISE;
  const bool flip = clockwise != (toRoot.det3() < 0);
  soup.triangles.push_back({first, first + (flip ? 2 : 1), first + (flip ? 1 : 2)});
}

SoCallbackAction::Response skipShape(void* data, SoCallbackAction*, const SoNode*) {
  ++static_cast<Gathering*>(data)->soup.shapesSkipped;
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response stopWhenTooMany(void* data, SoCallbackAction*, const SoNode*) {
  return static_cast<Gathering*>(data)->tooMany ? SoCallbackAction::ABORT : SoCallbackAction::CONTINUE;
}

void gather(SoNode* root, Gathering& gathering) {
  SoCallbackAction action;
  action.addTriangleCallback(SoShape::getClassTypeId(), takeTriangle, &gathering);
  action.addPreCallback(SoNode::getClassTypeId(), stopWhenTooMany, &gathering);
  for (const SoType type : {SoNurbsSurface::getClassTypeId(), SoIndexedNurbsSurface::getClassTypeId(),
                            SoNurbsCurve::getClassTypeId(), SoIndexedNurbsCurve::getClassTypeId()}) {
    action.addPreCallback(type, skipShape, &gathering);
  }
  action.apply(root);
}

}  // namespace

Result<PolygonSoup> readInventor(std::string_view file, const std::filesystem::path& folder) {
  static std::mutex oneAtATime;
  const std::lock_guard lock(oneAtATime);
  static const bool started = (startCoin(), true);
  (void)started;
  said().clear();

  if (deepestNesting(file) > kDeepestNesting) {
    return refused("", "nests more than " + std::to_string(kDeepestNesting) + " levels deep");
  }
  ConfinedInput input(folder);
  input.setBuffer(file.data(), file.size());
  SoSeparator* root = input.isValidBuffer() ? SoDB::readAll(&input) : nullptr;
  if (root == nullptr) {
    return refused("", "cannot be read as Open Inventor" + (said().empty() ? "" : ": Coin says " + inQuotes(said())));
  }
  root->ref();
  Gathering gathering;
  gathering.soup.shapesSkipped = input.leftOut();
  gather(root, gathering);
  root->unref();
  if (gathering.tooMany) return refused("", "holds more than " + std::to_string(kMaxTriangles) + " triangles");
  gathering.soup.verticesInFile = gathering.soup.vertices.size();
  return std::move(gathering.soup);
}

}  // namespace haptics
