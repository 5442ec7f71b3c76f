#include <array>
#include <bit>
#include <cstring>

#include "common/mesh/plain_file.h"
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

Result<PlainFile> plainBinary(std::string_view file) {
  const std::uint64_t triangles = claimedTriangles(file);
  for (std::uint64_t corner = 0; corner < 3 * triangles; ++corner) {
    std::array<float, 3> point;
    const std::size_t at = kHeader + corner / 3 * kRecord + kNormal + corner % 3 * sizeof point;
    std::memcpy(point.data(), file.data() + at, sizeof point);
    for (const float x : point) {
      if (auto ok = coordinate(static_cast<double>(x), corner); !ok) return tl::unexpected(std::move(ok).error());
    }
  }
  const std::size_t size = kHeader + triangles * kRecord;
  PlainFile plain;
  plain.bytes = file.substr(0, size);
  plain.bytesAtEnd = file.size() - size;
  plain.binary = true;
  plain.vertices = 3 * triangles;
  plain.triangles = triangles;
  return plain;
}

/// Takes the three vertices of a loop, each "vertex x y z", up to "endloop".
Result<void> addFacet(std::string_view& rest, PlainFile& plain) {
  plain.bytes += "facet normal 0 0 0\nouter loop\n";
  for (int k = 0; k < 3; ++k) {
    if (const std::string_view word = nextWord(rest); word != "vertex") {
      return refused("", "triangle " + std::to_string(plain.triangles) + " (from 0) has " + inQuotes(word) +
                             " where \"vertex\" should be");
    }
    plain.bytes += "vertex";
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = nextWord(rest);
      if (auto ok = coordinate(word, plain.vertices); !ok) return tl::unexpected(std::move(ok).error());
      (plain.bytes += ' ') += word;
    }
    plain.bytes += '\n';
    ++plain.vertices;
  }
  if (nextWord(rest) != "endloop") {
    return refused("", "triangle " + std::to_string(plain.triangles) + " (from 0) does not end after three vertices");
  }
  plain.bytes += "endloop\nendfacet\n";
  ++plain.triangles;
  return {};
}

Result<PlainFile> plainText(std::string_view file) {
  PlainFile plain;
  plain.bytes = "solid\n";
  bool ended = false;
  for (std::string_view word = nextWord(file); !word.empty(); word = nextWord(file)) {
    if (word == "solid" || word == "endsolid") {
      ended = word == "endsolid";
      (void)nextLine(file);  // the solid's name, which may be anything
    } else if (word == "loop") {
      if (auto ok = addFacet(file, plain); !ok) return tl::unexpected(std::move(ok).error());
    }
  }
  if (!ended) {
    return refused("",
                   "is cut off: it ends after " + std::to_string(plain.triangles) + " triangles without \"endsolid\"");
  }
  plain.bytes += "endsolid\n";
  return plain;
}

}  // namespace

// A binary file may begin with "solid" too, so its length decides; text holds no byte 0. Other programs leave notes of
// their own after the last triangle.
Result<PlainFile> plainStl(std::string_view file) {
  Result<PlainFile> plain;
  const bool isWhole = file.size() >= kHeader && file.size() >= kHeader + kRecord * claimedTriangles(file);
  if (isWhole && (claimedTriangles(file) > 0 || file.size() == kHeader)) {
    plain = plainBinary(file);
  } else if (std::string_view rest = file; nextWord(rest) == "solid" && file.find('\0') == file.npos) {
    plain = plainText(file);
  } else if (file.size() < kHeader) {
    return refused("", "is cut off: the header of a binary STL file alone takes " + std::to_string(kHeader) + " bytes");
  } else {
    return refused("", "its header claims " + std::to_string(claimedTriangles(file)) +
                           " triangles; the file's length " + "holds " +
                           std::to_string((file.size() - kHeader) / kRecord));
  }
  if (plain) {
    plain->polygons = plain->triangles;
    plain->readerDropsDegenerate = true;
  }
  return plain;
}

}  // namespace haptics
