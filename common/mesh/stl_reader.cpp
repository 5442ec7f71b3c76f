#include <array>
#include <bit>
#include <cstring>

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

/// Of the last three vertices.
void addTriangle(PolygonSoup& soup) {
  const auto end = static_cast<std::uint32_t>(soup.vertices.size());
  soup.triangles.push_back({end - 3, end - 2, end - 1});
}

std::string numbered(std::uint64_t vertex) { return "vertex " + std::to_string(vertex) + " (from 0) "; }

Result<PolygonSoup> readBinary(std::string_view file) {
  const std::uint64_t triangles = claimedTriangles(file);
  PolygonSoup soup;
  soup.isFloat32 = true;
  for (std::uint64_t corner = 0; corner < 3 * triangles; ++corner) {
    std::array<float, 3> point;
    const std::size_t at = kHeader + corner / 3 * kRecord + kNormal + corner % 3 * sizeof point;
    std::memcpy(point.data(), file.data() + at, sizeof point);
    soup.vertices.emplace_back(point[0], point[1], point[2]);
    if (const char* fault = faultOf(soup.vertices.back())) return refused("", numbered(corner) + fault);
    if (corner % 3 == 2) addTriangle(soup);
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
    if (!isEnded_)
      return refused("", "ends after " + triangles + " without \"endsolid\": it is cut off, or needs that line");
    if (soup_.triangles.empty())
      return refused("", "holds no face: no \"facet\" is between \"solid\" and \"endsolid\"");
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

  /// What follows "facet": "normal" and three words, "outer loop", three vertices, "endloop".
  Result<void> takeFacet() {
    const auto refuse = [this](const std::string& why) {
      return refusedAt(scan_, "triangle " + std::to_string(soup_.triangles.size()) + " (from 0) " + why);
    };
    constexpr int kWordsOfNormal = 4;
    std::string keyword = next();
    for (int k = 0; k < kWordsOfNormal && keyword != "outerloop"; ++k) keyword = next();
    if (keyword != "outerloop") {
      return refuse("has " + inQuotes(keyword) + " where \"outer loop\" should be");
    }
    for (int k = 0; k < 3; ++k) {
      if (const std::string word = next(); word != "vertex") {
        return refuse("has " + inQuotes(word) + " where \"vertex\" should be");
      }
      const auto point = nextPoint(scan_, soup_.vertices.size(), true);
      if (!point) return tl::unexpected(point.error());
      if (const char* fault = faultOf(*point)) return refusedAt(scan_, numbered(soup_.vertices.size()) + fault);
      soup_.vertices.push_back(*point);
    }
    if (next() != "endloop") return refuse("does not end after three vertices");
    addTriangle(soup_);
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

}  // namespace

// The length decides whether a file is binary. Other programs leave notes of their own after the last triangle.
Result<PolygonSoup> readStl(std::string_view file) {
  const bool isWhole = file.size() >= kHeader && file.size() >= kHeader + kRecord * claimedTriangles(file);
  if (isWhole && (claimedTriangles(file) > 0 || file.size() == kHeader)) return readBinary(file);
  const auto text = plainText(file);
  if (!text) return tl::unexpected(text.error());
  if (isText(*text)) return StlText(*text).read();
  if (file.size() < kHeader) {
    return refused("", "is cut off: the header of a binary STL file alone takes " + std::to_string(kHeader) + " bytes");
  }
  return refused("", "its header claims " + std::to_string(claimedTriangles(file)) + " triangles; the file's length " +
                         "holds " + std::to_string((file.size() - kHeader) / kRecord));
}

}  // namespace haptics
