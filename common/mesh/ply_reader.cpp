#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/face_list.h"
#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"
#include "common/text/plain_text.h"

namespace haptics {
namespace {

enum class Format { kText, kLittleEndian, kBigEndian };

struct Scalar {
  std::size_t size = 0;
  char kind = 0;  // 'i' signed, 'u' unsigned, 'f' floating
};

struct Property {
  std::string name;
  Scalar type;
  std::optional<Scalar> listCount;  // of a list: the type of its length
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  Format format = Format::kText;
  std::vector<Element> elements;
  std::uint64_t linesSkipped = 0;
  TextScan body{std::string_view()};
};

std::optional<Scalar> scalarNamed(std::string_view name) {
  struct Named {
    std::string_view name, alias;
    Scalar type;
  };
  static constexpr Named kScalars[] = {{"char", "int8", {1, 'i'}},     {"uchar", "uint8", {1, 'u'}},
                                       {"short", "int16", {2, 'i'}},   {"ushort", "uint16", {2, 'u'}},
                                       {"int", "int32", {4, 'i'}},     {"uint", "uint32", {4, 'u'}},
                                       {"float", "float32", {4, 'f'}}, {"double", "float64", {8, 'f'}},
                                       {"long", "int64", {8, 'i'}},    {"ulong", "uint64", {8, 'u'}}};
  for (const Named& scalar : kScalars) {
    if (isWord(name, scalar.name) || isWord(name, scalar.alias)) return scalar.type;
  }
  return std::nullopt;
}

/// Takes statements by their words: several may be in one line.
class PlyHeaderReader {
 public:
  explicit PlyHeaderReader(std::string_view file) : scan_(file) {}

  Result<PlyHeader> read() && {
    if (!isWord(scan_.word(), "ply")) return refused("", "does not begin with \"ply\"");
    const bool endsLinesByCr = isAtCr();
    for (;;) {
      const std::string_view keyword = scan_.word();
      if (keyword.empty()) return refused("", "is cut off: its header has no \"end_header\"");
      if (isWord(keyword, "end_header")) break;
      if (auto ok = take(keyword); !ok) return tl::unexpected(std::move(ok).error());
    }
    if (header_.format != Format::kText && endsLinesByCr && scan_.rest().starts_with('\r')) {
      header_.body = TextScan(scan_.rest().substr(1));  // a line feed after it is the body's
    } else {
      scan_.skipLine();
      header_.body = scan_;
    }
    return std::move(header_);
  }

 private:
  /// Whether this line ends here, with a carriage return alone as far as can be seen.
  [[nodiscard]] bool isAtCr() const { return scan_.rest().starts_with('\r') && !scan_.rest().starts_with("\r\n"); }

  Result<void> take(std::string_view keyword) {
    if (isWord(keyword, "format")) return takeFormat();
    if (isWord(keyword, "element")) return takeElement();
    if (isWord(keyword, "property")) return takeProperty();
    if (!isWord(keyword, "comment") && !isWord(keyword, "obj_info")) ++header_.linesSkipped;
    scan_.skipLine();
    return {};
  }

  Result<void> takeFormat() {
    const std::string_view name = scan_.wordOfLine();
    (void)scan_.wordOfLine();  // its version
    if (isWord(name, "ascii")) {
      header_.format = Format::kText;
    } else if (isWord(name, "binary_little_endian")) {
      header_.format = Format::kLittleEndian;
    } else if (isWord(name, "binary_big_endian")) {
      header_.format = Format::kBigEndian;
    } else {
      return refusedAt(scan_, "the header gives the format " + inQuotes(name) +
                                  "; it should be ascii, binary_little_endian or binary_big_endian");
    }
    return {};
  }

  Result<void> takeElement() {
    Element element;
    element.name = inLowerCase(scan_.wordOfLine());
    const auto count = asInteger(scan_.wordOfLine());
    if (!count || *count < 0) return refusedAt(scan_, "the header gives no count of " + inQuotes(element.name));
    element.count = static_cast<std::uint64_t>(*count);
    header_.elements.push_back(std::move(element));
    return {};
  }

  Result<void> takeProperty() {
    if (header_.elements.empty()) return refusedAt(scan_, "the header has a property before the first element");
    Property property;
    std::string_view word = scan_.wordOfLine();
    if (isWord(word, "list")) {
      word = scan_.wordOfLine();
      property.listCount = scalarNamed(word);
      if (!property.listCount) {
        return refusedAt(scan_, "the header counts a list in " + inQuotes(word) + ", which is no type of PLY");
      }
      word = scan_.wordOfLine();
    }
    const auto type = scalarNamed(word);
    if (!type) {
      return refusedAt(scan_, "the header gives a property the type " + inQuotes(word) + ", which PLY does not have");
    }
    property.type = *type;
    property.name = inLowerCase(scan_.wordOfLine());
    header_.elements.back().properties.push_back(std::move(property));
    return {};
  }

  TextScan scan_;
  PlyHeader header_;
};

/// The fewest bytes that one item of the element takes in the file. In text, a value takes a digit and a separator.
std::uint64_t minSize(const Element& element, Format format) {
  std::uint64_t size = 0;
  for (const Property& property : element.properties) {
    size += format == Format::kText ? 2 : property.listCount ? property.listCount->size : property.type.size;
  }
  return size;
}

bool isFloat32(Scalar type) { return type.kind == 'f' && type.size == sizeof(float); }

/// In text: lines of comments, which should be in the header only.
void skipCommentLines(TextScan& scan) {
  for (TextScan ahead = scan;;) {
    const std::string_view word = ahead.word();
    if (!isWord(word, "comment") && !isWord(word, "obj_info")) return;
    ahead.skipLine();
    scan = ahead;
  }
}

/// Reads the body's values one after the other.
class Values {
 public:
  /// @param byLine  In text, an item's values are in one line, and what the line has more is left out.
  Values(const TextScan& body, Format format, bool byLine)
      : text_(body), rest_(body.rest()), format_(format), byLine_(byLine) {}

  [[nodiscard]] std::size_t bytesLeft() const { return isText() ? text_.size() : rest_.size(); }
  [[nodiscard]] bool isText() const { return format_ == Format::kText; }
  /// Where the last value was; 0 in a binary file.
  [[nodiscard]] std::uint64_t line() const { return isText() ? text_.line() : 0; }
  /// In text, the last value as it is written; empty at the end.
  [[nodiscard]] std::string_view word() const { return word_; }

  /// Nothing at the end of the file and where text is not a number.
  [[nodiscard]] std::optional<double> next(Scalar type) {
    if (isText()) {
      word_ = std::exchange(isInLine_, byLine_) ? text_.wordOfLine() : text_.word();
      return asNumber(word_);
    }
    if (rest_.size() < type.size) return std::nullopt;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.size; ++i) {
      const std::size_t place = format_ == Format::kLittleEndian ? i : type.size - 1 - i;
      bits |= std::uint64_t{static_cast<unsigned char>(rest_[i])} << (8 * place);
    }
    rest_.remove_prefix(type.size);
    return valueOf(bits, type);
  }

  void skipComments() {
    if (isText()) skipCommentLines(text_);
  }

  /// Whether the line had more.
  bool endItem() {
    isInLine_ = false;
    if (!byLine_ || text_.wordOfLine().empty()) return false;
    text_.skipLine();
    return true;
  }

  /// Bytes after the last value; 0 where only blanks are.
  [[nodiscard]] std::size_t bytesAtEnd() const { return isText() && TextScan(text_).word().empty() ? 0 : bytesLeft(); }

 private:
  static double valueOf(std::uint64_t bits, Scalar type) {
    if (isFloat32(type)) {
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    if (type.kind == 'f') return std::bit_cast<double>(bits);
    if (type.kind == 'u') return static_cast<double>(bits);
    const int unused = 64 - 8 * static_cast<int>(type.size);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
  }

  TextScan text_;
  std::string_view rest_;  ///< Of a binary file.
  Format format_;
  bool byLine_, isInLine_ = false;
  std::string_view word_;
};

/// Of a vertex's property: 0, 1 or 2; nothing if it is no coordinate.
std::optional<int> axisOf(const Property& property) {
  if (property.listCount || property.name.size() != 1) return std::nullopt;
  const int axis = property.name[0] - 'x';
  return axis >= 0 && axis <= 2 ? std::optional(axis) : std::nullopt;
}

/// Elements that hold faces.
struct Faces {
  std::size_t element = 0, corners = 0;  ///< Of the header, and of its properties.
  bool areStrips = false;
};
/// What is read of the header's elements.
struct Geometry {
  std::size_t vertex = 0;
  std::vector<Faces> faces;
};

/// Reads the body, element by element.
class Body {
 public:
  Body(const PlyHeader& header, const Geometry& geometry, bool byLine)
      : header_(header), geometry_(geometry), values_(header.body, header.format, byLine) {
    soup_.headerLinesSkipped = header.linesSkipped;
  }

  Result<void> read() {
    for (std::size_t i = 0; i < header_.elements.size(); ++i) {
      if (auto ok = take(i); !ok) return ok;
    }
    values_.skipComments();
    soup_.bytesAtEnd = values_.bytesAtEnd();
    return faces_.addTo(soup_);
  }

  [[nodiscard]] bool usedAll() const { return soup_.bytesAtEnd == 0; }
  /// Nothing was left out of the lines that are read.
  [[nodiscard]] bool usedLines() const { return soup_.linesSkipped == 0; }
  [[nodiscard]] PolygonSoup finish() && { return std::move(soup_); }

 private:
  Result<void> take(std::size_t index) {
    const Element& element = header_.elements[index];
    const auto faces = std::ranges::find(geometry_.faces, index, &Faces::element);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      values_.skipComments();
      const bool taken = index == geometry_.vertex        ? takeVertex(element)
                         : faces != geometry_.faces.end() ? takeFace(element, *faces)
                                                          : skip(element);
      if (!taken) return tl::unexpected(cutOff(element, i));
      if (values_.endItem()) ++soup_.linesSkipped;
    }
    if (index == geometry_.vertex && element.count > 0) return checkVerticesEnd(index);
    return {};
  }

  /// In text by words.
  Result<void> checkVerticesEnd(std::size_t vertex) const {
    const std::vector<Element>& elements = header_.elements;
    const bool beforeFaces = geometry_.faces.front().element == vertex + 1 && !geometry_.faces.front().areStrips;
    if (!beforeFaces || !values_.isText()) return {};
    const auto isList = [](const Property& property) { return property.listCount.has_value(); };
    const std::vector<Property>& ofFace = elements[vertex + 1].properties;
    const std::string_view body = header_.body.rest();
    const bool isFace = geometry_.faces.front().corners == 0 && std::ranges::count_if(ofFace, isList) == 1 &&
                        std::ranges::none_of(elements[vertex].properties, isList) &&
                        endsWithinFace(body.substr(0, body.size() - values_.bytesLeft()),
                                       body.substr(body.size() - values_.bytesLeft()),
                                       elements[vertex].properties.size(), ofFace.size() - 1);
    if (!isFace) return {};
    return refused("", "line " + std::to_string(values_.line()) + ": is a face, where the " +
                           std::to_string(elements[vertex].count) +
                           " vertices end: one has too few numbers, or there are fewer");
  }

  [[nodiscard]] Error cutOff(const Element& element, std::uint64_t i) const {
    const std::string where = element.name + ' ' + std::to_string(i) + " (from 0) of " + std::to_string(element.count);
    const std::string_view word = values_.word();
    if (word.empty()) return {"", "is cut off or damaged: it ends in " + where};
    return {"", "line " + std::to_string(values_.line()) + ": " + where + " has " + inQuotes(word) +
                    " as the length of a list"};
  }

  /// The values of one property: one, or the list's. Nothing at the end of the file.
  [[nodiscard]] const std::vector<double>* next(const Property& property) {
    list_.clear();
    double length = 1;
    if (property.listCount) {
      const auto value = values_.next(*property.listCount);
      // Each value takes at least a byte, so that a claim is never reserved beyond the file's length.
      if (!value || !(*value >= 0 && *value <= static_cast<double>(values_.bytesLeft()))) return nullptr;
      if (*value != std::floor(*value)) return nullptr;
      length = *value;
    }
    for (double i = 0; i < length; ++i) {
      const auto value = values_.next(property.type);
      if (!value) return nullptr;
      list_.push_back(*value);
    }
    return &list_;
  }

  bool takeVertex(const Element& element) {
    Vec3 point(0);
    for (const Property& property : element.properties) {
      const auto* value = next(property);
      if (value == nullptr) return false;
      const auto axis = axisOf(property);
      if (!axis) continue;
      point[*axis] = value->front();
      if (!values_.isText() && isFloat32(property.type)) soup_.isFloat32 = true;
    }
    soup_.vertices.push_back(point);
    return true;
  }

  bool takeFace(const Element& element, const Faces& faces) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const auto* value = next(element.properties[i]);
      if (value == nullptr) return false;
      if (i != faces.corners) continue;
      if (faces.areStrips) {
        addStrips(*value);
      } else {
        for (const double vertex : *value) faces_.addCorner(indexOf(vertex));
        faces_.endFace(values_.line());
      }
    }
    return true;
  }

  /// Triangles that share two corners with the one before, every second one turned over; -1 begins anew.
  void addStrips(const std::vector<double>& vertices) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i] < 0) begin = i + 1;
      if (i < begin + 2) continue;
      const std::size_t turned = (i - begin) % 2;
      for (const std::size_t corner : {i - 2 + turned, i - 1 - turned, i}) faces_.addCorner(indexOf(vertices[corner]));
      faces_.endFace(values_.line());
    }
  }

  bool skip(const Element& element) {
    return std::all_of(element.properties.begin(), element.properties.end(),
                       [this](const Property& property) { return next(property) != nullptr; });
  }

  static std::int64_t indexOf(double vertex) {
    const bool isWhole = std::abs(vertex) < 1e18 && vertex == std::floor(vertex);
    return isWhole ? static_cast<std::int64_t>(vertex) : -1;
  }

  const PlyHeader& header_;
  Geometry geometry_;
  Values values_;
  PolygonSoup soup_;
  FaceList faces_;
  std::vector<double> list_;
};

std::string namesOf(const auto& named) {
  std::string names;
  for (const auto& one : named) names += (names.empty() ? "" : ", ") + inQuotes(one.name);
  return names.empty() ? "none" : names;
}

/// The list of a face that names its vertices: by its usual names, or the only one of whole numbers.
Result<std::size_t> cornersOf(const Element& element) {
  std::optional<std::size_t> only;
  std::size_t lists = 0;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    if (!property.listCount) continue;
    if (property.name == "vertex_indices" || property.name == "vertex_index") return i;
    if (property.type.kind == 'f') continue;
    only = i;
    ++lists;
  }
  if (lists == 1) return *only;
  return refused("", "its header gives " + inQuotes(element.name) + " no list \"vertex_indices\"; its properties are " +
                         namesOf(element.properties));
}

Result<Geometry> geometryOf(const PlyHeader& header) {
  const std::vector<Element>& elements = header.elements;
  const auto find = [&](std::string_view name) {
    const auto at = std::find_if(elements.begin(), elements.end(), [=](const Element& e) { return e.name == name; });
    return static_cast<std::size_t>(at - elements.begin());
  };
  Geometry geometry{.vertex = find("vertex"), .faces = {}};
  const std::size_t faces = find("face"), strips = find("tristrips"), none = elements.size();
  if (geometry.vertex == none || (faces == none && strips == none)) {
    return refused(
        "",
        "is no mesh (a point cloud?): its header should have elements \"vertex\" and \"face\" or \"tristrips\"; "
        "it has " +
            namesOf(elements));
  }
  for (const std::size_t of : {faces, strips}) {
    if (of != none && elements[of].count > 0) geometry.faces.push_back({of, 0, of == strips});
  }
  if (geometry.faces.empty()) return refused("", "holds no face (a point cloud?): its header gives 0 of them");
  const Element& vertex = elements[geometry.vertex];
  for (const std::string_view axis : {"x", "y", "z"}) {
    const auto isAxis = [=](const Property& p) { return p.name == axis && !p.listCount; };
    if (std::none_of(vertex.properties.begin(), vertex.properties.end(), isAxis)) {
      return refused("", "its header gives vertices no property " + inQuotes(axis) + "; their properties are " +
                             namesOf(vertex.properties));
    }
  }
  for (Faces& each : geometry.faces) {
    const auto corners = cornersOf(elements[each.element]);
    if (!corners) return tl::unexpected(corners.error());
    each.corners = *corners;
  }
  return geometry;
}

/// Refused, naming its line, if the body of a text has a word that is no number.
Result<void> checkPlyNumbers(TextScan scan) {
  for (;; scan.skipLine()) {
    skipCommentLines(scan);
    for (std::string_view word = scan.word(); !word.empty(); word = scan.wordOfLine()) {
      if (!asNumber(word)) return refusedAt(scan, inQuotes(word) + " where a number should be");
    }
    if (scan.size() == 0) return {};
  }
}

Result<void> checkCounts(const PlyHeader& header) {
  const std::size_t size = header.body.size() + 1;
  for (const Element& element : header.elements) {
    const std::uint64_t least = minSize(element, header.format);
    if (least == 0 && element.count > 0) {
      return refused("", "its header gives " + inQuotes(element.name) + " no property");
    }
    if (least > 0 && element.count > size / least) {
      return refused("", "its header claims " + std::to_string(element.count) + " of " + inQuotes(element.name) +
                             "; the file's length holds at most " + std::to_string(size / least));
    }
  }
  return {};
}

}  // namespace

// Text is read by words, whatever its lines; where that fails, line by line, if words too many at their ends are all that is wrong.
Result<PolygonSoup> readPly(std::string_view file) {
  const auto text = plainText(file);
  if (!text) return tl::unexpected(text.error());
  auto header = PlyHeaderReader(withoutByteOrderMark(file)).read();
  if (!header) return tl::unexpected(std::move(header).error());
  if (header->format == Format::kText) header = PlyHeaderReader(*text).read();
  const auto geometry = geometryOf(*header);
  if (!geometry) return tl::unexpected(geometry.error());
  if (auto ok = checkCounts(*header); !ok) return tl::unexpected(std::move(ok).error());
  Body words(*header, *geometry, false);
  const auto byWords = words.read();
  const bool isText = header->format == Format::kText;
  if (!isText && !byWords) return tl::unexpected(byWords.error());
  if (!isText || (byWords && words.usedAll())) return std::move(words).finish();
  Body lines(*header, *geometry, true);
  const auto byLine = lines.read();
  if (byWords && byLine && lines.usedLines()) return std::move(lines).finish();  // something else follows
  if (auto ok = checkPlyNumbers(header->body); !ok) return tl::unexpected(std::move(ok).error());
  if (byLine && lines.usedAll()) return std::move(lines).finish();
  if (!byWords) return tl::unexpected(byWords.error());
  return std::move(words).finish();
}

}  // namespace haptics
