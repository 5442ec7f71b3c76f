#include <vector>

#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

struct FaceLine {
  std::string_view corners;
  std::uint64_t number;    ///< Of the line, from 1.
  std::int64_t seenSoFar;  ///< Vertices above it: what negative indices count back from.
};

/// "7", "7/1", "7//3" or "-1/2/3": the vertex part counts from 1, or back from the last vertex so far.
Result<void> addFace(FaceLine face, PolygonSoup& soup) {
  std::vector<std::uint32_t> corners;
  for (std::string_view word = nextWord(face.corners); !word.empty(); word = nextWord(face.corners)) {
    if (word.front() == '#') break;
    const auto index = asInteger(word.substr(0, word.find('/')));
    if (!index) {
      return refused("", "line " + std::to_string(face.number) + " has " + inQuotes(word) +
                             " where a face should name a vertex, as in \"f 1 2 3\" or \"f 1/4/2 2/5/2 3/6/2\"");
    }
    const std::int64_t vertex = *index < 0 ? face.seenSoFar + *index + 1 : *index;
    corners.push_back(soup.numbered(vertex - 1));
  }
  soup.addPolygon(corners);
  return {};
}

}  // namespace

Result<PolygonSoup> readObj(std::string_view file) {
  PolygonSoup soup;
  std::vector<FaceLine> faces;
  for (std::uint64_t number = 1; !file.empty(); ++number) {
    std::string_view line = nextLine(file);
    const std::string_view keyword = nextWord(line);
    if (keyword == "v") {
      const auto point = nextPoint(line, soup.vertices.size());
      if (!point) return tl::unexpected(point.error());
      soup.vertices.push_back(*point);
    } else if (keyword == "f") {
      faces.push_back({line, number, static_cast<std::int64_t>(soup.vertices.size())});
    }
  }
  for (const FaceLine& face : faces) {
    if (auto ok = addFace(face, soup); !ok) return tl::unexpected(std::move(ok).error());
  }
  return soup;
}

}  // namespace haptics
