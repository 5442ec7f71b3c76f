#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"

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
};

std::optional<Scalar> scalarNamed(std::string_view name) {
  struct Named {
    std::string_view name, alias;
    Scalar type;
  };
  static constexpr Named kScalars[] = {{"char", "int8", {1, 'i'}},     {"uchar", "uint8", {1, 'u'}},
                                       {"short", "int16", {2, 'i'}},   {"ushort", "uint16", {2, 'u'}},
                                       {"int", "int32", {4, 'i'}},     {"uint", "uint32", {4, 'u'}},
                                       {"float", "float32", {4, 'f'}}, {"double", "float64", {8, 'f'}}};
  for (const Named& scalar : kScalars) {
    if (name == scalar.name || name == scalar.alias) return scalar.type;
  }
  return std::nullopt;
}

Result<Format> formatNamed(std::string_view name) {
  if (name == "ascii") return Format::kText;
  if (name == "binary_little_endian") return Format::kLittleEndian;
  if (name == "binary_big_endian") return Format::kBigEndian;
  return refused("", "its header gives the format " + inQuotes(name) +
                         "; it should be ascii, binary_little_endian or binary_big_endian");
}

Result<Property> readProperty(std::string_view line) {
  Property property;
  std::string_view word = nextWord(line);
  if (word == "list") {
    word = nextWord(line);
    property.listCount = scalarNamed(word);
    if (!property.listCount || property.listCount->kind == 'f') {
      return refused("", "its header counts a list in " + inQuotes(word) + ", which is no integer type of PLY");
    }
    word = nextWord(line);
  }
  const auto type = scalarNamed(word);
  if (!type) return refused("", "its header gives a property the type " + inQuotes(word) + ", which PLY does not have");
  property.type = *type;
  property.name = nextWord(line);
  return property;
}

Result<void> readPlyHeaderLine(std::string_view keyword, std::string_view line, PlyHeader& header) {
  if (keyword == "format") {
    const auto format = formatNamed(nextWord(line));
    if (!format) return tl::unexpected(format.error());
    header.format = *format;
  } else if (keyword == "element") {
    Element element;
    element.name = nextWord(line);
    const auto count = asInteger(nextWord(line));
    if (!count || *count < 0) return refused("", "its header gives no count of " + inQuotes(element.name));
    element.count = static_cast<std::uint64_t>(*count);
    header.elements.push_back(std::move(element));
  } else if (keyword == "property") {
    if (header.elements.empty()) return refused("", "its header has a property before the first element");
    auto property = readProperty(line);
    if (!property) return tl::unexpected(std::move(property).error());
    header.elements.back().properties.push_back(*std::move(property));
  } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
    ++header.linesSkipped;
  }
  return {};
}

/// Leaves `rest` at the body.
Result<PlyHeader> readPlyHeader(std::string_view& rest) {
  std::string_view first = nextLine(rest);
  if (nextWord(first) != "ply") return refused("", "does not begin with \"ply\"");
  PlyHeader header;
  while (!rest.empty()) {
    std::string_view line = nextLine(rest);
    const std::string_view keyword = nextWord(line);
    if (keyword == "end_header") return header;
    if (auto ok = readPlyHeaderLine(keyword, line, header); !ok) return tl::unexpected(std::move(ok).error());
  }
  return refused("", "is cut off: its header has no \"end_header\"");
}

/// The fewest bytes that one item of the element takes in the file. In text, a value takes a digit and a separator.
std::uint64_t minSize(const Element& element, Format format) {
  std::uint64_t size = 0;
  for (const Property& property : element.properties) {
    size += format == Format::kText ? 2 : property.listCount ? property.listCount->size : property.type.size;
  }
  return size;
}

/// Reads the body's values one after the other.
class Values {
 public:
  Values(std::string_view body, Format format) : rest_(body), format_(format) {}

  [[nodiscard]] std::size_t bytesLeft() const { return rest_.size(); }

  /// Nothing at the end of the file and where text is not a number.
  [[nodiscard]] std::optional<double> next(Scalar type) {
    if (format_ == Format::kText) return asNumber(nextWord(rest_));
    if (rest_.size() < type.size) return std::nullopt;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.size; ++i) {
      const std::size_t place = format_ == Format::kLittleEndian ? i : type.size - 1 - i;
      bits |= std::uint64_t{static_cast<unsigned char>(rest_[i])} << (8 * place);
    }
    rest_.remove_prefix(type.size);
    return valueOf(bits, type);
  }

 private:
  static double valueOf(std::uint64_t bits, Scalar type) {
    if (type.kind == 'f' && type.size == sizeof(float)) {
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    if (type.kind == 'f') return std::bit_cast<double>(bits);
    if (type.kind == 'u') return static_cast<double>(bits);
    const int unused = 64 - 8 * static_cast<int>(type.size);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
  }

  std::string_view rest_;
  Format format_;
};

/// Reads the body, element by element.
class Body {
 public:
  Body(std::string_view body, const PlyHeader& header) : values_(body, header.format) {
    soup_.headerLinesSkipped = header.linesSkipped;
  }

  Result<void> take(const Element& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const auto taken = element.name == "vertex" ? takeVertex(element)
                         : element.name == "face" ? takeFace(element)
                                                  : skip(element);
      if (!taken) return tl::unexpected(taken.error());
      if (!*taken) {
        return refused("", "is cut off or damaged: it ends, or holds something that is no number, in " + element.name +
                               ' ' + std::to_string(i) + " (from 0) of " + std::to_string(element.count));
      }
    }
    return {};
  }

  [[nodiscard]] PolygonSoup finish() && { return std::move(soup_); }

 private:
  /// The values of one property: one, or the list's. Nothing at the end of the file.
  [[nodiscard]] const std::vector<double>* next(const Property& property) {
    list_.clear();
    double length = 1;
    if (property.listCount) {
      const auto value = values_.next(*property.listCount);
      // Each value takes at least a byte, so that a claim is never reserved beyond the file's length.
      if (!value || !(*value >= 0 && *value <= static_cast<double>(values_.bytesLeft()))) return nullptr;
      length = *value;
    }
    for (double i = 0; i < length; ++i) {
      const auto value = values_.next(property.type);
      if (!value) return nullptr;
      list_.push_back(*value);
    }
    return &list_;
  }

  Result<bool> takeVertex(const Element& element) {
    for (const Property& property : element.properties) {
      const auto* value = next(property);
      if (value == nullptr) return false;
      if (property.listCount || (property.name != "x" && property.name != "y" && property.name != "z")) continue;
      const auto coordinate = haptics::coordinate(value->front(), soup_.vertices.size());
      if (!coordinate) return tl::unexpected(coordinate.error());
      point_[property.name[0] - 'x'] = static_cast<double>(*coordinate);
    }
    soup_.vertices.push_back(point_);
    return true;
  }

  Result<bool> takeFace(const Element& element) {
    for (const Property& property : element.properties) {
      const auto* value = next(property);
      if (value == nullptr) return false;
      if (property.listCount && (property.name == "vertex_indices" || property.name == "vertex_index")) addFace(*value);
    }
    return true;
  }

  Result<bool> skip(const Element& element) {
    return std::all_of(element.properties.begin(), element.properties.end(),
                       [this](const Property& property) { return next(property) != nullptr; });
  }

  void addFace(const std::vector<double>& vertices) {
    corners_.clear();
    for (const double vertex : vertices)
      corners_.push_back(soup_.numbered(std::abs(vertex) < 1e18 ? static_cast<std::int64_t>(std::floor(vertex)) : -1));
    soup_.addPolygon(corners_);
  }

  Values values_;
  PolygonSoup soup_;
  Vec3 point_{0};
  std::vector<double> list_;
  std::vector<std::uint32_t> corners_;
};

Result<void> checkElements(const PlyHeader& header, std::size_t bodySize) {
  const auto find = [&header](std::string_view name) {
    return std::find_if(header.elements.begin(), header.elements.end(),
                        [=](const Element& e) { return e.name == name; });
  };
  const auto vertex = find("vertex"), face = find("face"), none = header.elements.end();
  if (vertex == none || face == none || vertex > face) {
    return refused("",
                   "is no mesh (a point cloud?): its header should have an element \"vertex\" and after it a \"face\"");
  }
  for (const std::string_view axis : {"x", "y", "z"}) {
    const auto isAxis = [=](const Property& p) { return p.name == axis && !p.listCount; };
    if (std::none_of(vertex->properties.begin(), vertex->properties.end(), isAxis)) {
      return refused("", "its header gives vertices no property " + inQuotes(axis));
    }
  }
  for (const Element& element : header.elements) {
    const std::uint64_t least = minSize(element, header.format);
    if (least == 0) return refused("", "its header gives " + inQuotes(element.name) + " no property");
    if (element.count > (bodySize + 1) / least) {
      return refused("", "its header claims " + std::to_string(element.count) + " of " + inQuotes(element.name) +
                             "; the file's length holds at most " + std::to_string((bodySize + 1) / least));
    }
  }
  return {};
}

}  // namespace

Result<PolygonSoup> readPly(std::string_view file) {
  const auto header = readPlyHeader(file);
  if (!header) return tl::unexpected(header.error());
  if (auto ok = checkElements(*header, file.size()); !ok) return tl::unexpected(std::move(ok).error());
  Body body(file, *header);
  for (const Element& element : header->elements) {
    if (auto ok = body.take(element); !ok) return tl::unexpected(std::move(ok).error());
  }
  return std::move(body).finish();
}

}  // namespace haptics
