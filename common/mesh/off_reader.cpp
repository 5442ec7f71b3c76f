#include <vector>

#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

/// The next line that holds something, without its comment; empty at the end of the file.
std::string_view nextContent(std::string_view& rest) {
  while (!rest.empty()) {
    std::string_view line = nextLine(rest);
    line = line.substr(0, line.find('#'));
    std::string_view words = line;
    if (!nextWord(words).empty()) return line;
  }
  return {};
}

struct OffCounts {
  std::uint64_t vertices, faces;
};

/// "OFF" (or with ST, C, N before it, whose texture coordinates, colours and normals are left out), then the counts of
/// vertices, faces and edges on the same or the next line.
Result<OffCounts> readOffHeader(std::string_view& rest) {
  std::string_view line = nextContent(rest);
  std::string_view keyword = nextWord(line);
  const std::string_view written = keyword;
  for (const std::string_view prefix : {"ST", "C", "N"}) {
    if (keyword.starts_with(prefix)) keyword.remove_prefix(prefix.size());
  }
  if (keyword != "OFF") return refused("", "begins with " + inQuotes(written) + "; an OFF file begins with \"OFF\"");
  std::string_view first = nextWord(line);
  if (first == "BINARY") return refused("", "is a binary OFF file; save it as text");
  if (first.empty()) {
    line = nextContent(rest);
    first = nextWord(line);
  }
  const auto vertices = asInteger(first), faces = asInteger(nextWord(line));
  if (!vertices || !faces || *vertices < 0 || *faces < 0) {
    return refused("", "its header should give the number of vertices, faces and edges, as in \"8 6 12\"");
  }
  return OffCounts{static_cast<std::uint64_t>(*vertices), static_cast<std::uint64_t>(*faces)};
}

Result<void> addFace(std::string_view line, std::uint64_t number, PolygonSoup& soup) {
  const auto bad = [number](const std::string& why) {
    return refused("", "face " + std::to_string(number) + " (from 0) " + why);
  };
  const auto count = asInteger(nextWord(line));
  // Two characters a corner is the least that it takes.
  if (!count || *count < 0 || static_cast<std::uint64_t>(*count) > line.size() / 2) {
    return bad("should begin with the number of its corners and then name as many vertices");
  }
  std::vector<std::uint32_t> corners;
  for (std::int64_t k = 0; k < *count; ++k) {
    const std::string_view word = nextWord(line);
    const auto vertex = asInteger(word);
    if (!vertex) return bad(word.empty() ? "has fewer corners than it says" : "has " + inQuotes(word) + " as a corner");
    corners.push_back(soup.numbered(*vertex));
  }
  soup.addPolygon(corners);
  return {};
}

}  // namespace

Result<PolygonSoup> readOff(std::string_view file) {
  auto counts = readOffHeader(file);
  if (!counts) return tl::unexpected(std::move(counts).error());
  constexpr std::uint64_t kMinVertex = 6, kMinFace = 2;  // characters of "0 0 0\n" and "0\n"
  if (counts->vertices > file.size() / kMinVertex + 1 || counts->faces > file.size() / kMinFace + 1) {
    return refused("", "its header claims " + std::to_string(counts->vertices) + " vertices and " +
                           std::to_string(counts->faces) + " faces, more than its length can hold");
  }
  PolygonSoup soup;
  for (std::uint64_t i = 0; i < counts->vertices; ++i) {
    std::string_view line = nextContent(file);
    if (line.empty()) {
      return refused("", "ends after " + std::to_string(i) + " of " + std::to_string(counts->vertices) + " vertices");
    }
    const auto point = nextPoint(line, i);
    if (!point) return tl::unexpected(point.error());
    soup.vertices.push_back(*point);
  }
  for (std::uint64_t i = 0; i < counts->faces; ++i) {
    const std::string_view line = nextContent(file);
    if (line.empty()) {
      return refused("", "ends after " + std::to_string(i) + " of " + std::to_string(counts->faces) + " faces");
    }
    if (auto ok = addFace(line, i, soup); !ok) return tl::unexpected(std::move(ok).error());
  }
  return soup;
}

}  // namespace haptics
