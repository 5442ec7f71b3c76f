#include <optional>
#include <string>
#include <utility>

#include "common/mesh/face_list.h"
#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"
#include "common/text/plain_text.h"

namespace haptics {
namespace {

enum class Statement { kVertex, kFace, kNumbers, kNames, kShape, kLine, kPoint, kUnknown };

struct Keyword {
  std::string_view name;
  Statement statement;
};

// The format's keywords, as Alias|Wavefront's manual of version 3.0 lists them (appendix B1). "fo" is version 2.11's "f".
constexpr Keyword kKeywords[] = {
    {"v", Statement::kVertex},      {"f", Statement::kFace},           {"fo", Statement::kFace},
    {"vt", Statement::kNumbers},    {"vn", Statement::kNumbers},       {"vp", Statement::kNumbers},
    {"p", Statement::kPoint},       {"l", Statement::kLine},           {"curv", Statement::kShape},
    {"surf", Statement::kShape},    {"bzp", Statement::kShape},        {"bsp", Statement::kShape},
    {"cdc", Statement::kShape},     {"cdp", Statement::kShape},        {"call", Statement::kShape},
    {"curv2", Statement::kNumbers}, {"parm", Statement::kNumbers},     {"trim", Statement::kNumbers},
    {"hole", Statement::kNumbers},  {"scrv", Statement::kNumbers},     {"sp", Statement::kNumbers},
    {"con", Statement::kNumbers},   {"deg", Statement::kNumbers},      {"bmat", Statement::kNumbers},
    {"step", Statement::kNumbers},  {"res", Statement::kNumbers},      {"cstype", Statement::kNames},
    {"end", Statement::kNames},     {"g", Statement::kNames},          {"o", Statement::kNames},
    {"s", Statement::kNames},       {"mg", Statement::kNames},         {"usemtl", Statement::kNames},
    {"mtllib", Statement::kNames},  {"usemap", Statement::kNames},     {"maplib", Statement::kNames},
    {"bevel", Statement::kNames},   {"c_interp", Statement::kNames},   {"d_interp", Statement::kNames},
    {"lod", Statement::kNames},     {"shadow_obj", Statement::kNames}, {"trace_obj", Statement::kNames},
    {"ctech", Statement::kNames},   {"stech", Statement::kNames},      {"csh", Statement::kNames},
};

Statement statementOf(std::string_view keyword) {
  for (const auto& [name, statement] : kKeywords) {
    if (isWord(keyword, name)) return statement;
  }
  return Statement::kUnknown;
}

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : scan_(text, TextScan::Comments::kHash) {}

  Result<PolygonSoup> read() && {
    for (; scan_.size() > 0; scan_.skipLine()) {
      if (auto ok = takeStatement(); !ok) return tl::unexpected(std::move(ok).error());
    }
    if (faces_.empty()) return tl::unexpected(withoutFaces());
    if (auto ok = faces_.addTo(soup_); !ok) return tl::unexpected(std::move(ok).error());
    return std::move(soup_);
  }

 private:
  Result<void> takeStatement() {
    const TextScan atStart = scan_;
    const std::string_view keyword = withoutByteOrderMark(nextWord());  // of files put together
    switch (statementOf(keyword)) {
      case Statement::kVertex:
        return takeVertex();
      case Statement::kFace:
        return takeFace();
      case Statement::kNumbers:
        return skipNumbers();
      case Statement::kShape:
        ++soup_.shapesSkipped;
        return skipNumbers();
      case Statement::kLine:
        ++soup_.leftOut.lines;
        return skipNumbers();
      case Statement::kPoint:
        ++soup_.leftOut.points;
        return skipNumbers();
      case Statement::kNames:
        break;
      case Statement::kUnknown:
        if (keyword.empty() || soup_.linesSkipped++ > 0) break;
        firstSkipped_ = "line " + std::to_string(scan_.line()) + ": " + inQuotes(keyword);
    }
    scan_ = atStart;
    goesOn_ = false;  // a backslash at the end is the name's, as in those of folders of Windows
    return {};
  }

  /// The next word of the statement, which goes on in the next line after a backslash at the line's end.
  std::string_view nextWord() {
    for (;;) {
      if (std::exchange(goesOn_, false)) scan_.skipLine();
      std::string_view word = scan_.wordOfLine();
      if (!word.ends_with('\\')) return word;
      TextScan ahead = scan_;
      if (!ahead.wordOfLine().empty()) return word;  // not at the line's end
      goesOn_ = true;
      word.remove_suffix(1);
      if (!word.empty()) return word;
    }
  }

  /// Of a statement that is left out. Refused if it goes on in a line that looks like the next one.
  Result<void> skipNumbers() {
    const std::uint64_t line = scan_.line();
    for (std::string_view word = nextWord(); !word.empty(); word = nextWord()) {
      if (scan_.line() == line || statementOf(word) == Statement::kUnknown) continue;
      return refusedAt(scan_,
                       inQuotes(word) + " where a number should be, because the line before ends with a backslash");
    }
    return {};
  }

  Result<void> takeVertex() {
    const std::uint64_t line = scan_.line();
    Vec3 point;
    bool isNamed = false;
    for (int i = 0;; ++i) {
      const std::string_view word = nextWord();
      if (word.empty() && i >= 3) break;
      const auto value = asNumber(word);
      if (!value && i >= 3 && (scan_.line() == line || statementOf(word) == Statement::kUnknown)) {  // a colour's name
        isNamed = true;
        continue;
      }
      if (!value) {
        return refusedAt(
            scan_, "vertex " + std::to_string(soup_.vertices.size()) + " (from 0) has " +
                       (word.empty() ? "fewer than three coordinates" : inQuotes(word) + " where a number should be"));
      }
      if (i < 3) point[i] = *value;  // then come a weight or colours
    }
    soup_.vertices.push_back(point);
    soup_.linesSkipped += isNamed ? 1 : 0;
    return {};
  }

  /// The vertex part of a corner: "7", "7.0", "7/1" or "7\\1\\3".
  static std::optional<std::int64_t> vertexOf(std::string_view corner) {
    corner = corner.substr(0, corner.find_first_of("/\\"));
    const std::size_t point = corner.find('.');
    const bool isWhole = point != corner.npos && corner.find_first_not_of("0,", point + 1) == corner.npos;
    return asInteger(isWhole ? corner.substr(0, point) : corner);
  }

  /// "7", "7/1", "7//3" or "-1/2/3": the vertex part counts from 1, or back from the last vertex so far.
  Result<void> takeFace() {
    const std::uint64_t line = scan_.line();
    for (std::string_view word = nextWord(); !word.empty(); word = nextWord()) {
      const auto index = vertexOf(word);
      if (!index) {
        return refusedAt(scan_, inQuotes(word) + " where a face should name a vertex, as in \"f 1 2 3\" or " +
                                    "\"f 1/4/2 2/5/2 3/6/2\"");
      }
      const auto seenSoFar = static_cast<std::int64_t>(soup_.vertices.size());
      faces_.addCorner((*index < 0 ? seenSoFar + *index + 1 : *index) - 1);
    }
    faces_.endFace(line);
    return {};
  }

  [[nodiscard]] Error withoutFaces() const {
    std::string reason = "holds " + std::to_string(soup_.vertices.size()) + " vertices and no face (\"f\")";
    const auto mention = [&reason](std::uint64_t count, const std::string& what) {
      if (count > 0) reason += ", " + std::to_string(count) + ' ' + what;
    };
    mention(soup_.leftOut.lines + soup_.leftOut.points, "lines and points, which have no surface");
    mention(soup_.shapesSkipped, "free-form shapes, which are not read");
    mention(soup_.linesSkipped, "lines that begin with no keyword of OBJ, the first is " + firstSkipped_);
    return {"", reason + "; a mesh needs at least one face"};
  }

  TextScan scan_;
  PolygonSoup soup_;
  bool goesOn_ = false;  ///< In the next line.
  FaceList faces_;
  std::string firstSkipped_;
};

}  // namespace

Result<PolygonSoup> readObj(std::string_view file) {
  return plainText(file).and_then([](std::string_view text) { return ObjReader(text).read(); });
}

}  // namespace haptics
