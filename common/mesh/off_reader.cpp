#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/face_list.h"
#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"
#include "common/text/plain_text.h"

namespace haptics {
namespace {

struct OffHeader {
  std::uint64_t vertices = 0, faces = 0;
  int valuesAfterPoint = 0;    ///< Texture coordinates, normals; without colours.
  bool hasColours = false;     ///< Of three or four numbers, at the vertices.
  bool isHomogeneous = false;  ///< A fourth coordinate divides the other three.
  bool mayHaveEdges = false;   ///< The next number is their count, or the first coordinate.
};

/// Which numbers of the file belong to what. The format counts words; but it does not count those of a face's colour, which
/// goes to the end of the line.
struct OffLayout {
  bool byLine = true;  ///< Each vertex and each face begins a line, whose end is left out.
  bool hasEdges = false;
  int valuesOfVertex = 0, valuesOfFace = 0;  ///< By words: beyond the point and the corners.
};

/// "[ST][C][N][4]OFF" in any case and order, or nothing before the counts. "n" in front of "OFF" means points of n
/// dimensions; in a word of small letters only it is an "N".
Result<void> readKeyword(TextScan& scan, OffHeader& header) {
  const TextScan atStart = scan;
  const std::string_view written = scan.word();
  if (asInteger(written)) {
    scan = atStart;
    return {};
  }
  const auto bad = [&] {
    return refusedAt(scan, "begins with " + inQuotes(written) + "; an OFF file begins with \"OFF\"");
  };
  const std::string lower = inLowerCase(written.substr(0, std::string_view("STCN4nOFF").size()));
  const std::size_t end = lower.find("off");
  if (end == lower.npos) return bad();
  bool hasDimension = false;
  for (std::size_t i = 0; i < end; ++i) {
    const bool isSmallN = written[i] == 'n' && written[end] == 'O';
    if (lower.compare(i, 2, "st") == 0) {
      header.valuesAfterPoint += 2;
      ++i;
    } else if (lower[i] == 'c') {
      header.hasColours = true;
    } else if (lower[i] == 'n' && !isSmallN) {
      header.valuesAfterPoint += 3;
    } else if (isSmallN) {
      hasDimension = true;
    } else if (lower[i] == '4') {
      header.isHomogeneous = true;
    } else {
      return bad();
    }
  }
  const std::string_view joined = written.substr(end + 3);
  if (!joined.empty() && !asInteger(joined)) return bad();
  if (!joined.empty()) scan.goBack(joined.size());
  if (TextScan ahead = scan; isWord(ahead.word(), "binary")) {
    return refusedAt(ahead, "is a binary OFF file; save it as text");
  }
  if (hasDimension && scan.word() != "3") return refusedAt(scan, "its points should have 3 dimensions");
  return {};
}

Result<OffHeader> readHeader(TextScan& scan) {
  OffHeader header;
  if (auto ok = readKeyword(scan, header); !ok) return tl::unexpected(std::move(ok).error());
  const auto vertices = asInteger(scan.word()), faces = asInteger(scan.word());
  if (!vertices || !faces || *vertices < 0 || *faces < 0) {
    return refusedAt(scan, "the header should give the number of vertices, faces and edges, as in \"8 6 12\"");
  }
  header.vertices = static_cast<std::uint64_t>(*vertices);
  header.faces = static_cast<std::uint64_t>(*faces);
  if (TextScan ahead = scan; !ahead.wordOfLine().empty()) {
    (void)scan.wordOfLine();  // of edges
  } else {
    header.mayHaveEdges = true;
  }
  constexpr std::uint64_t kMinVertex = 6, kMinFace = 2;  // characters of "0 0 0\n" and "0\n"
  if (header.vertices > scan.size() / kMinVertex + 1 || header.faces > scan.size() / kMinFace + 1) {
    return refused("", "its header claims " + std::to_string(header.vertices) + " vertices and " +
                           std::to_string(header.faces) + " faces, more than its length can hold");
  }
  return header;
}

/// Which faces are cut into triangles, which takes most of the time.
enum class Cut { kAll, kWhileLikely, kNone };

class OffBody {
 public:
  OffBody(const TextScan& scan, const OffHeader& header, const OffLayout& layout, Cut cut)
      : scan_(scan), header_(header), layout_(layout), cut_(cut) {}

  Result<void> read() {
    if (layout_.hasEdges && !asInteger(scan_.word())) isLikely_ = false;
    for (std::uint64_t i = 0; i < header_.vertices; ++i) {
      if (auto ok = takeVertex(i); !ok) return ok;
    }
    atFaces_ = scan_;
    for (std::uint64_t i = 0; i < header_.faces; ++i) {
      if (auto ok = takeFace(i); !ok) return ok;
    }
    TextScan end = scan_;
    if (!end.word().empty()) soup_.bytesAtEnd = scan_.size();
    return {};
  }

  /// Nothing speaks against the layout: all words are used, and vertices and faces look alike.
  [[nodiscard]] bool isLikely() const { return isLikely_ && soup_.bytesAtEnd == 0; }
  /// What was read so far has its words where it should.
  [[nodiscard]] bool looksAlike() const { return isLikely_; }
  /// Where the vertices end.
  [[nodiscard]] const TextScan& atFaces() const { return atFaces_; }
  [[nodiscard]] PolygonSoup take() && { return std::move(soup_); }

 private:
  /// Skips what follows a vertex or a face. The number of words.
  int skip(int words) {
    int skipped = 0;
    if (layout_.byLine) {
      while (!scan_.wordOfLine().empty()) ++skipped;
    } else {
      while (skipped < words && !scan_.word().empty()) ++skipped;
      if (skipped < words) isLikely_ = false;
    }
    return skipped;
  }

  void leaveOut() {
    isLikely_ = false;
    ++soup_.linesSkipped;
  }

  [[nodiscard]] bool isAtEnd() const { return TextScan(scan_).word().empty(); }

  Result<void> takeVertex(std::uint64_t i) {
    if (isAtEnd()) return endsAfter(i, header_.vertices, "vertices");
    auto point = nextPoint(scan_, i, true);
    if (!point) return tl::unexpected(std::move(point).error());
    if (header_.isHomogeneous) {
      const auto divisor = asNumber(scan_.word());
      if (!divisor) return refusedAt(scan_, "vertex " + std::to_string(i) + " (from 0) has no fourth coordinate");
      *point /= *divisor;
    }
    soup_.vertices.push_back(*point);
    const int words = skip(layout_.valuesOfVertex);
    constexpr int kMaxWords = 12;  // words that are known: texture coordinates, normal, colour
    if (i == 0) wordsAfterFirst_ = words;
    if (words != wordsAfterFirst_ || words > kMaxWords) leaveOut();
    return {};
  }

  Result<void> takeFace(std::uint64_t i) {
    if (isAtEnd()) return endsAfter(i, header_.faces, "faces");
    const auto bad = [&](const std::string& why) {
      return refusedAt(scan_, "face " + std::to_string(i) + " (from 0) " + why);
    };
    const auto count = asInteger(scan_.word());
    // Two characters a corner is the least that it takes.
    if (!count || *count < 0 || static_cast<std::uint64_t>(*count) > scan_.size() / 2) {
      return bad("should begin with the number of its corners and then name as many vertices");
    }
    const std::uint64_t line = scan_.line();
    corners_.clear();
    for (std::int64_t k = 0; k < *count; ++k) {
      const std::string_view word = scan_.word();
      const auto vertex = asInteger(word);
      if (!vertex)
        return bad(word.empty() ? "has fewer corners than it says" : "has " + inQuotes(word) + " as a corner");
      corners_.push_back(soup_.numbered(*vertex));
    }
    if (cut_ == Cut::kAll || (cut_ == Cut::kWhileLikely && isLikely_)) {
      if (auto ok = addFace(corners_, line, soup_); !ok) return ok;
    }
    const int words = skip(layout_.valuesOfFace);
    if (words == 2 || words > 4) leaveOut();  // a colour has one, three or four numbers
    if (*count < 3) isLikely_ = false;
    return {};
  }

  [[nodiscard]] tl::unexpected<Error> endsAfter(std::uint64_t found, std::uint64_t all, const std::string& what) const {
    return refused("", "ends after " + std::to_string(found) + " of " + std::to_string(all) + ' ' + what);
  }

  TextScan scan_;
  OffHeader header_;
  OffLayout layout_;
  Cut cut_;
  TextScan atFaces_{std::string_view()};
  PolygonSoup soup_;
  std::vector<std::uint32_t> corners_;
  bool isLikely_ = true;
  int wordsAfterFirst_ = 0;
};

/// Those by words, each of which takes up all words of few files.
std::vector<OffLayout> layoutsByWords(const OffHeader& header) {
  std::vector<OffLayout> layouts;
  for (const bool hasEdges : {true, false}) {
    if (hasEdges && !header.mayHaveEdges) continue;
    for (const int colourOfVertex : {4, 3, 0}) {
      if ((colourOfVertex > 0) != header.hasColours) continue;
      for (const int colourOfFace : {0, 3, 4, 1}) {
        layouts.push_back({false, hasEdges, header.valuesAfterPoint + colourOfVertex, colourOfFace});
      }
    }
  }
  return layouts;
}

/// Refused, naming its line, if a word after the header is no number.
Result<void> checkOffNumbers(TextScan scan) {
  for (std::string_view word = scan.word(); !word.empty(); word = scan.word()) {
    if (!asNumber(word)) return refusedAt(scan, inQuotes(word) + " where a number should be");
  }
  return {};
}

}  // namespace

// Line by line, as almost all files are written; where that leaves something over or comes short, by words, if one way of
// counting them comes out even.
Result<PolygonSoup> readOff(std::string_view file) {
  const auto text = plainText(file);
  if (!text) return tl::unexpected(text.error());
  TextScan scan(*text, TextScan::Comments::kHash);
  const auto header = readHeader(scan);
  if (!header) return tl::unexpected(header.error());
  if (header->faces == 0) {
    return refused("", "holds no face: its header gives " + std::to_string(header->vertices) + " vertices and 0 faces");
  }
  TextScan afterCounts = scan;
  const bool edgesAlone = header->mayHaveEdges && asInteger(afterCounts.word()) && afterCounts.wordOfLine().empty();
  const OffLayout ofLines{.byLine = true, .hasEdges = edgesAlone};
  OffBody lines(scan, *header, ofLines, Cut::kWhileLikely);
  const auto byLine = lines.read();
  if (byLine && lines.isLikely()) return std::move(lines).take();
  std::optional<OffLayout> even;
  std::optional<Error> byWords;
  bool isWithinFace = false;
  for (const OffLayout& layout : layoutsByWords(*header)) {
    OffBody words(scan, *header, layout, Cut::kNone);
    const auto read = words.read();
    if (!read && !byWords) byWords = read.error();
    if (!read || !words.isLikely()) continue;
    const TextScan& at = words.atFaces();
    const std::size_t vertexWords =
        3 + (header->isHomogeneous ? 1 : 0) + static_cast<std::size_t>(layout.valuesOfVertex);
    if (endsWithinFace(scan.rest().substr(0, scan.size() - at.size()), at.rest(), vertexWords,
                       static_cast<std::size_t>(layout.valuesOfFace))) {
      byWords = refusedAt(at, "is a face, where the " + std::to_string(header->vertices) +
                                  " vertices end: one has too few numbers, or there are fewer")
                    .value();
      isWithinFace = true;
      continue;
    }
    if (even) {
      return refused("",
                     "can be read in more than one way; it should have each vertex and each face in a line of its own");
    }
    even = layout;
  }
  const auto readAs = [&](const OffLayout& layout) {
    OffBody body(scan, *header, layout, Cut::kAll);
    return body.read().map([&] { return std::move(body).take(); });
  };
  if (even) return readAs(*even);
  if (isWithinFace) return tl::unexpected(*byWords);
  if (byLine && lines.looksAlike()) return std::move(lines).take();
  if (auto ok = checkOffNumbers(scan); !ok) return tl::unexpected(std::move(ok).error());
  if (byLine) return readAs(ofLines);
  return tl::unexpected(lines.looksAlike() || !byWords ? byLine.error() : *byWords);
}

}  // namespace haptics
