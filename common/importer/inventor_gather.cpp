#include "common/importer/inventor_gather.h"

#include <Inventor/SbMatrix.h>
#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoInteraction.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/errors/SoDebugError.h>
#include <Inventor/errors/SoMemoryError.h>
#include <Inventor/errors/SoReadError.h>
#include <Inventor/nodes/SoIndexedFaceSet.h>
#include <Inventor/nodes/SoIndexedLineSet.h>
#include <Inventor/nodes/SoIndexedNurbsCurve.h>
#include <Inventor/nodes/SoIndexedNurbsSurface.h>
#include <Inventor/nodes/SoIndexedPointSet.h>
#include <Inventor/nodes/SoIndexedTriangleStripSet.h>
#include <Inventor/nodes/SoLineSet.h>
#include <Inventor/nodes/SoNurbsCurve.h>
#include <Inventor/nodes/SoNurbsSurface.h>
#include <Inventor/nodes/SoPointSet.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>
#include <Inventor/nodes/SoVertexProperty.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <deque>
#include <string>
#include <utility>

#include "common/mesh/text_scan.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {
namespace {

/// Deepest nesting of braces in a text file: Coin reads and walks by recursion, about a kilobyte of stack a level. Real
/// models nest below 50.
constexpr int kDeepestNesting = 500;

/// Messages of Coin while it reads a file, which would go to stderr.
std::string& said() {
  static std::string text;
  return text;
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

/// The result of fopen() while Coin opens a file that it may include; null: none.
const std::string*& handedOver() {
  static const std::string* bytes = nullptr;
  return bytes;
}
bool& opensFiles() {
  static bool itself = true;
  return itself;
}

/// Lets a file include what the reader gives.
class ConfinedInput final : public SoInput {
 public:
  explicit ConfinedInput(const IncludeReader& readIncluded) : readIncluded_(readIncluded) {}

  [[nodiscard]] std::uint64_t leftOut() const { return leftOut_; }

  SbBool pushFile(const char* name) override {
    auto bytes = readIncluded_(name);
    if (bytes && deepestNesting(*bytes) <= kDeepestNesting) {
      handedOver() = &included_.emplace_back(*std::move(bytes));
      const SbBool pushed = SoInput::pushFile((std::string("/") + name).c_str());  // as no path to be searched for
      handedOver() = nullptr;
      if (pushed) return TRUE;
    }
    ++leftOut_;
    return FALSE;
  }

 private:
  const IncludeReader& readIncluded_;
  std::deque<std::string> included_;  // Coin reads them where they are
  std::uint64_t leftOut_ = 0;
};

struct Gathering {
  PolygonSoup found;
  std::string fault;  // ends the walk
};

void takeTriangle(void* data, SoCallbackAction* action, const SoPrimitiveVertex* a, const SoPrimitiveVertex* b,
                  const SoPrimitiveVertex* c) {
  auto& [found, fault] = *static_cast<Gathering*>(data);
  if (found.triangles.size() >= kMaxTriangles) {
    fault = "holds more than " + std::to_string(kMaxTriangles) + " triangles";
    return;
  }
  const SbMatrix& toRoot = action->getModelMatrix();
  // Vertices run clockwise where the file says so, and where a mirroring transform turns them round.
  const bool clockwise = action->getVertexOrdering() == SoShapeHints::CLOCKWISE;
  if (clockwise != (toRoot.det3() < 0)) std::swap(b, c);
  for (const SoPrimitiveVertex* vertex : {a, b, c}) {
    SbVec3f point;
    toRoot.multVecMatrix(vertex->getPoint(), point);
    found.vertices.emplace_back(point[0], point[1], point[2]);
  }
  const auto end = static_cast<std::uint32_t>(found.vertices.size());
  found.triangles.push_back({end - 3, end - 2, end - 1});
}

SoCallbackAction::Response skipNurbs(void* data, SoCallbackAction*, const SoNode*) {
  ++static_cast<Gathering*>(data)->found.shapesSkipped;
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response skipLinesAndPoints(void*, SoCallbackAction*, const SoNode*) {
  return SoCallbackAction::PRUNE;
}

SoCallbackAction::Response stopAtFault(void* data, SoCallbackAction*, const SoNode*) {
  return static_cast<Gathering*>(data)->fault.empty() ? SoCallbackAction::CONTINUE : SoCallbackAction::ABORT;
}

/// Coin does not look whether the points that a shape names are there.
SoCallbackAction::Response checkIndices(void* data, SoCallbackAction* action, const SoNode* node) {
  const auto& shape = static_cast<const SoIndexedShape&>(*node);
  const auto* own = static_cast<const SoVertexProperty*>(shape.vertexProperty.getValue());
  const int count = own != nullptr && own->vertex.getNum() > 0 ? own->vertex.getNum() : action->getNumCoordinates();
  for (int i = 0; i < shape.coordIndex.getNum(); ++i) {
    if (const int point = shape.coordIndex[i]; point >= count) {
      static_cast<Gathering*>(data)->fault =
          "a shape names point " + std::to_string(point) + " of " + std::to_string(count) + "; count from 0";
      return SoCallbackAction::ABORT;
    }
  }
  return SoCallbackAction::CONTINUE;
}

void gather(SoNode* root, Gathering& gathering) {
  SoCallbackAction action;
  action.addTriangleCallback(SoShape::getClassTypeId(), takeTriangle, &gathering);
  action.addPreCallback(SoNode::getClassTypeId(), stopAtFault, &gathering);
  for (const SoType type : {SoNurbsSurface::getClassTypeId(), SoIndexedNurbsSurface::getClassTypeId(),
                            SoNurbsCurve::getClassTypeId(), SoIndexedNurbsCurve::getClassTypeId()}) {
    action.addPreCallback(type, skipNurbs, &gathering);
  }
  for (const SoType type : {SoLineSet::getClassTypeId(), SoIndexedLineSet::getClassTypeId(),
                            SoPointSet::getClassTypeId(), SoIndexedPointSet::getClassTypeId()}) {
    action.addPreCallback(type, skipLinesAndPoints, &gathering);
  }
  for (const SoType type : {SoIndexedFaceSet::getClassTypeId(), SoIndexedTriangleStripSet::getClassTypeId()}) {
    action.addPreCallback(type, checkIndices, &gathering);
  }
  action.apply(root);
}

}  // namespace

void startInventor() {
  const auto keep = [](const SoError* error, void*) {
    if (said().empty()) said() = error->getDebugString().getString();
  };
  SoDB::init();
  SoInteraction::init();
  SoError::setHandlerCallback(keep, nullptr);
  SoDebugError::setHandlerCallback(keep, nullptr);
  SoReadError::setHandlerCallback(keep, nullptr);
  SoMemoryError::setHandlerCallback(keep, nullptr);
}

Result<PolygonSoup> gatherInventor(std::string_view file, const IncludeReader& readIncluded) {
  opensFiles() = false;
  if (deepestNesting(file) > kDeepestNesting) {
    return refused("", "nests more than " + std::to_string(kDeepestNesting) + " levels deep");
  }
  ConfinedInput input(readIncluded);
  input.setBuffer(file.data(), file.size());
  SoSeparator* root = input.isValidBuffer() ? SoDB::readAll(&input) : nullptr;
  if (root == nullptr) {
    return refused("", "cannot be read as Open Inventor" + (said().empty() ? "" : ": Coin says " + inQuotes(said())));
  }
  root->ref();
  Gathering gathering;
  gathering.found.shapesSkipped = input.leftOut();
  gather(root, gathering);
  root->unref();
  if (!gathering.fault.empty()) return refused("", gathering.fault);
  return std::move(gathering.found);
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
