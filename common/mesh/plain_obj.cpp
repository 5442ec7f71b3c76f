#include <vector>

#include "common/mesh/plain_file.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

struct FaceLine {
  std::string_view corners;
  std::uint64_t number;    ///< Of the line, from 1.
  std::int64_t seenSoFar;  ///< Vertices above it: what negative indices count back from.
};

void appendLine(std::string& bytes, std::string_view keyword, const std::vector<std::string_view>& words) {
  bytes += keyword;
  for (const std::string_view word : words) (bytes += ' ') += word;
  bytes += '\n';
}

Result<void> addObjVertex(std::string_view line, PlainFile& plain) {
  std::vector<std::string_view> words;
  for (int axis = 0; axis < 3; ++axis) {
    words.push_back(nextWord(line));
    if (auto ok = coordinate(words.back(), plain.vertices); !ok) return tl::unexpected(std::move(ok).error());
  }
  appendLine(plain.bytes, "v", words);
  ++plain.vertices;
  return {};
}

/// "7", "7/1", "7//3" or "-1/2/3": the vertex part counts from 1, or back from the last vertex so far.
Result<void> addFace(FaceLine face, PlainFile& plain) {
  const auto count = static_cast<std::int64_t>(plain.vertices);
  std::vector<std::string> corners;
  bool inRange = true;
  for (std::string_view word = nextWord(face.corners); !word.empty(); word = nextWord(face.corners)) {
    if (word.front() == '#') break;
    const auto index = asInteger(word.substr(0, word.find('/')));
    if (!index) {
      return refused("", "line " + std::to_string(face.number) + " has " + inQuotes(word) +
                             " where a face should name a vertex, as in \"f 1 2 3\" or \"f 1/4/2 2/5/2 3/6/2\"");
    }
    const std::int64_t vertex = *index < 0 ? face.seenSoFar + *index + 1 : *index;
    inRange = inRange && vertex >= 1 && vertex <= count;
    corners.push_back(std::to_string(vertex));
  }
  if (corners.size() < 3) {
    ++plain.degenerate;
  } else if (!inRange) {
    plain.outOfRange += corners.size() - 2;
  } else {
    ++plain.polygons;
    plain.triangles += corners.size() - 2;
    appendLine(plain.bytes, "f", {corners.begin(), corners.end()});
  }
  return {};
}

}  // namespace

Result<PlainFile> plainObj(std::string_view file) {
  PlainFile plain;
  plain.readerDropsDegenerate = true;
  plain.bytes.reserve(file.size());
  std::vector<FaceLine> faces;
  for (std::uint64_t number = 1; !file.empty(); ++number) {
    std::string_view line = nextLine(file);
    const std::string_view keyword = nextWord(line);
    if (keyword == "v") {
      if (auto ok = addObjVertex(line, plain); !ok) return tl::unexpected(std::move(ok).error());
    } else if (keyword == "f") {
      faces.push_back({line, number, static_cast<std::int64_t>(plain.vertices)});
    }
  }
  for (const FaceLine& face : faces) {
    if (auto ok = addFace(face, plain); !ok) return tl::unexpected(std::move(ok).error());
  }
  return plain;
}

}  // namespace haptics
