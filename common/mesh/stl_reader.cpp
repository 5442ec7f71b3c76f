#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "common/mesh/face_list.h"
#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"
#include "common/text/plain_text.h"

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

std::uint64_t heldTriangles(std::string_view file) { return (file.size() - kHeader) / kRecord; }

/// Of the last three vertices.
void addTriangle(PolygonSoup& soup) {
  const auto end = static_cast<std::uint32_t>(soup.vertices.size());
  soup.triangles.push_back({end - 3, end - 2, end - 1});
}

std::string numbered(std::uint64_t vertex) { return "vertex " + std::to_string(vertex) + " (from 0) "; }

std::array<Vec3, 3> triangleAt(std::string_view file, std::uint64_t triangle) {
  std::array<std::array<float, 3>, 3> points;
  std::memcpy(points.data(), file.data() + kHeader + triangle * kRecord + kNormal, sizeof points);
  std::array<Vec3, 3> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k] = Vec3(points[k][0], points[k][1], points[k][2]);
  return corners;
}

/// Whether what follows the triangles that a header counts is more of them: they have an area, and are near those.
bool areTriangles(std::string_view file, std::uint64_t counted, std::uint64_t held) {
  constexpr double kNear = 10;  // sizes of the box of those that are counted
  Vec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (std::uint64_t i = 0; i < counted; ++i) {
    for (const Vec3& corner : triangleAt(file, i)) {
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  }
  const Vec3 reach(kNear * glm::length(high - low));
  for (std::uint64_t i = counted; i < held; ++i) {
    const auto corners = triangleAt(file, i);
    for (const Vec3& corner : corners) {
      if (!glm::all(glm::lessThanEqual(glm::abs(corner - low), reach))) return false;
    }
    if (!hasArea(Vec3f(corners[0]), Vec3f(corners[1]), Vec3f(corners[2]))) return false;
  }
  return true;
}

/// Some programs write the header before they know the count, and never fill it in: 0, the largest number, or too few of
/// them. The length then says it, if it comes out even.
std::uint64_t countedTriangles(std::string_view file) {
  const std::uint64_t claimed = claimedTriangles(file), held = heldTriangles(file);
  if (claimed == held || (file.size() - kHeader) % kRecord != 0) return claimed;
  const bool isOpen = claimed == 0 || claimed == std::numeric_limits<std::uint32_t>::max();
  return isOpen || (claimed < held && areTriangles(file, claimed, held)) ? held : claimed;
}

std::string countsMore(std::string_view file) {
  return "its header claims " + std::to_string(claimedTriangles(file)) + " triangles; the file's length holds " +
         std::to_string(heldTriangles(file));
}

Result<PolygonSoup> readBinary(std::string_view file, std::uint64_t triangles) {
  PolygonSoup soup;
  soup.isFloat32 = true;
  soup.countsIgnored = triangles != claimedTriangles(file) ? 1 : 0;
  for (std::uint64_t i = 0; i < triangles; ++i) {
    for (const Vec3& corner : triangleAt(file, i)) {
      if (const char* fault = faultOf(corner)) return refused("", numbered(soup.vertices.size()) + fault);
      soup.vertices.push_back(corner);
    }
    addTriangle(soup);
  }
  soup.bytesAtEnd = file.size() - (kHeader + triangles * kRecord);
  return soup;
}

/// Keywords are taken in any case, apart or joined: "EndLoop", "end loop", "outerloop".
class StlText {
 public:
  explicit StlText(std::string_view text) : scan_(text, TextScan::Comments::kHash) {}

  Result<PolygonSoup> read() && {
    for (std::string keyword = next(); !keyword.empty(); keyword = next()) {
      if (keyword == "solid" || keyword == "endsolid") {
        isEnded_ = keyword == "endsolid";
        skipName();
      } else if (keyword == "facet") {
        if (auto ok = takeFacet(); !ok) return tl::unexpected(std::move(ok).error());
      } else if (keyword != "endfacet") {
        ++soup_.linesSkipped;
        scan_.skipLine();
      }
    }
    const std::string triangles = std::to_string(soup_.triangles.size()) + " triangles";
    if (soup_.triangles.empty()) return refused("", "holds no face: no \"facet\" follows \"solid\"");
    if (!isEnded_) {
      soup_.cutOff =
          "ends after " + triangles + ", which are not closed, without \"endsolid\": it is cut off, or needs that line";
    }
    return std::move(soup_);
  }

 private:
  /// The next keyword in lower case, in one word; empty at the end.
  std::string next() {
    const std::string_view first = scan_.word();
    if (first.size() > kLongestKeyword) return std::string(first);
    std::string keyword = inLowerCase(first);
    if (keyword != "end" && keyword != "outer") return keyword;
    TextScan ahead = scan_;
    const std::string_view second = ahead.word();
    for (const std::string_view name : {"loop", "facet", "solid"}) {
      if (!isWord(second, name)) continue;
      scan_ = ahead;
      return keyword.append(name);
    }
    return keyword;
  }

  /// The solid's name, which may be anything. It ends with the line, or with "facet normal" and a number in it.
  void skipName() {
    for (TextScan before = scan_;; before = scan_) {
      const std::string_view word = scan_.wordOfLine();
      if (word.empty()) return;
      if (!isWord(word, "facet")) continue;
      TextScan ahead = scan_;
      if (!isWord(ahead.word(), "normal") || !asNumber(ahead.word())) continue;
      scan_ = before;
      return;
    }
  }

  /// What follows "facet": "normal" and three words, "outer loop", three vertices or more, "endloop". Other lines are left out.
  Result<void> takeFacet() {
    const auto refuse = [this](const std::string& why) {
      return refusedAt(scan_, "triangle " + std::to_string(soup_.triangles.size()) + " (from 0) " + why);
    };
    const auto isKnown = [](std::string_view keyword) {
      return keyword == "vertex" || keyword == "outerloop" || keyword.starts_with("end") || keyword.empty();
    };
    constexpr int kWordsOfNormal = 4;
    std::string keyword = next();
    for (int k = 0; k < kWordsOfNormal && !isKnown(keyword); ++k) keyword = next();
    std::vector<std::uint32_t> corners;
    TextScan before = scan_;
    for (;; before = scan_, keyword = next()) {
      if (keyword == "vertex") {
        const auto point = nextPoint(scan_, soup_.vertices.size(), true);
        if (!point) return tl::unexpected(point.error());
        if (const char* fault = faultOf(*point)) return refusedAt(scan_, numbered(soup_.vertices.size()) + fault);
        corners.push_back(static_cast<std::uint32_t>(soup_.vertices.size()));
        soup_.vertices.push_back(*point);
      } else if (keyword == "facet" || keyword == "solid" || keyword == "endsolid") {
        scan_ = before;
        break;
      } else if (keyword == "endloop" || keyword == "endfacet") {
        break;
      } else if (keyword.empty()) {
        return refuse("is cut off");
      } else if (keyword != "outerloop") {
        ++soup_.linesSkipped;
        scan_.skipLine();
      }
    }
    if (corners.size() < 3)
      return refuse("has " + std::to_string(corners.size()) + " lines \"vertex\", of three or more");
    soup_.addPolygon(corners);
    return {};
  }

  static constexpr std::size_t kLongestKeyword = 20;

  TextScan scan_;
  PolygonSoup soup_;
  bool isEnded_ = false;
};

/// Text says "solid" first, or "facet normal" somewhere; a binary file's 80 bytes may begin with "solid" too.
bool isText(std::string_view text) {
  TextScan scan(text);
  if (isWord(scan.word(), "solid") && text.find('\0') == text.npos) return true;
  for (;;) {
    const std::string_view word = scan.word();
    if (word.empty()) return false;
    if (isWord(word, "facet") && isWord(TextScan(scan).word(), "normal")) return true;
  }
}

bool isAllText(std::string_view file) {
  constexpr std::string_view kBlanks = "\t\n\v\f\r\x1a";
  return std::ranges::none_of(
      file, [&](char c) { return static_cast<unsigned char>(c) < ' ' && kBlanks.find(c) == kBlanks.npos; });
}

}  // namespace

// The length decides whether a file is binary. Other programs leave notes of their own after the last triangle.
Result<PolygonSoup> readStl(std::string_view file) {
  const std::uint64_t triangles = file.size() < kHeader ? 0 : countedTriangles(file);
  const bool isWhole = file.size() >= kHeader && file.size() >= kHeader + kRecord * triangles;
  const bool isCounted = isWhole && triangles == claimedTriangles(file);
  if (isCounted && (triangles > 0 || file.size() == kHeader)) return readBinary(file, triangles);
  const auto text = plainText(file);
  if (!text) return tl::unexpected(text.error());
  if (isText(*text)) return StlText(*text).read();
  if (const std::string_view unmarked = withoutByteOrderMark(file); unmarked.size() < file.size()) {
    return readStl(unmarked);
  }
  if (isAllText(*text)) {
    TextScan scan(*text);
    std::string begin(scan.word());
    for (std::string_view word = scan.wordOfLine(); !word.empty(); word = scan.wordOfLine())
      begin.append(1, ' ').append(word);
    return refused("", "is no STL: it is text that begins with " + inQuotes(begin) + ", not with \"solid\"");
  }
  if (isWhole && triangles > 0) return readBinary(file, triangles);
  if (file.size() > kHeader && (file.size() - kHeader) % kRecord == 0) {
    if (__builtin_bswap32(static_cast<std::uint32_t>(claimedTriangles(file))) == heldTriangles(file)) {
      return refused("", "has its numbers in big-endian order; those of binary STL are little-endian");
    }
    return readBinary(file, heldTriangles(file)).map([&](PolygonSoup soup) {
      soup.cutOff = countsMore(file) + ", which are not closed";
      return soup;
    });
  }
  if (file.size() < kHeader) {
    return refused("", "is cut off: the header of a binary STL file alone takes " + std::to_string(kHeader) + " bytes");
  }
  return refused("", countsMore(file));
}

}  // namespace haptics
