#include <array>
#include <bit>
#include <cstring>

#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

constexpr std::size_t kComment = 80, kHeader = kComment + sizeof(std::uint32_t);
constexpr std::size_t kRecord = 50;  // bytes a triangle: normal, three vertices (float32 each), 16 bits of attributes
constexpr std::size_t kNormal = 3 * sizeof(float);

std::uint64_t claimedTriangles(std::string_view file) {
  static_assert(std::endian::native == std::endian::little);
  std::uint32_t count = 0;
  std::memcpy(&count, file.data() + kComment, sizeof count);
  return count;
}

/// Of the last three vertices.
void addTriangle(PolygonSoup& soup) {
  const auto end = static_cast<std::uint32_t>(soup.vertices.size());
  soup.triangles.push_back({end - 3, end - 2, end - 1});
}

Result<PolygonSoup> readBinary(std::string_view file) {
  const std::uint64_t triangles = claimedTriangles(file);
  PolygonSoup soup;
  for (std::uint64_t corner = 0; corner < 3 * triangles; ++corner) {
    std::array<float, 3> point;
    const std::size_t at = kHeader + corner / 3 * kRecord + kNormal + corner % 3 * sizeof point;
    std::memcpy(point.data(), file.data() + at, sizeof point);
    for (const float x : point) {
      if (auto ok = coordinate(static_cast<double>(x), corner); !ok) return tl::unexpected(std::move(ok).error());
    }
    soup.vertices.emplace_back(point[0], point[1], point[2]);
    if (corner % 3 == 2) addTriangle(soup);
  }
  soup.bytesAtEnd = file.size() - (kHeader + triangles * kRecord);
  return soup;
}

/// Takes the three vertices of a loop, each "vertex x y z", up to "endloop".
Result<void> addFacet(std::string_view& rest, PolygonSoup& soup) {
  const std::string triangle = "triangle " + std::to_string(soup.triangles.size()) + " (from 0) ";
  for (int k = 0; k < 3; ++k) {
    if (const std::string_view word = nextWord(rest); word != "vertex") {
      return refused("", triangle + "has " + inQuotes(word) + " where \"vertex\" should be");
    }
    const auto point = nextPoint(rest, soup.vertices.size());
    if (!point) return tl::unexpected(point.error());
    soup.vertices.push_back(*point);
  }
  if (nextWord(rest) != "endloop") return refused("", triangle + "does not end after three vertices");
  addTriangle(soup);
  return {};
}

Result<PolygonSoup> readText(std::string_view file) {
  PolygonSoup soup;
  bool ended = false;
  for (std::string_view word = nextWord(file); !word.empty(); word = nextWord(file)) {
    if (word == "solid" || word == "endsolid") {
      ended = word == "endsolid";
      (void)nextLine(file);  // the solid's name, which may be anything
    } else if (word == "loop") {
      if (auto ok = addFacet(file, soup); !ok) return tl::unexpected(std::move(ok).error());
    }
  }
  if (!ended) {
    return refused(
        "", "is cut off: it ends after " + std::to_string(soup.triangles.size()) + " triangles without \"endsolid\"");
  }
  return soup;
}

}  // namespace

// A binary file may begin with "solid" too, so its length decides; text holds no byte 0. Other programs leave notes of
// their own after the last triangle.
Result<PolygonSoup> readStl(std::string_view file) {
  const bool isWhole = file.size() >= kHeader && file.size() >= kHeader + kRecord * claimedTriangles(file);
  if (isWhole && (claimedTriangles(file) > 0 || file.size() == kHeader)) return readBinary(file);
  if (std::string_view rest = file; nextWord(rest) == "solid" && file.find('\0') == file.npos) return readText(file);
  if (file.size() < kHeader) {
    return refused("", "is cut off: the header of a binary STL file alone takes " + std::to_string(kHeader) + " bytes");
  }
  return refused("", "its header claims " + std::to_string(claimedTriangles(file)) + " triangles; the file's length " +
                         "holds " + std::to_string((file.size() - kHeader) / kRecord));
}

}  // namespace haptics
