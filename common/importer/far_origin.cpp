#include "common/importer/far_origin.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/inflater.h"
#include "common/importer/xml_text.h"

namespace haptics {
namespace {

constexpr std::string_view kBetween = " \t\r\n,";

/// The box around positions.
struct Box {
  Vec3 low{std::numeric_limits<double>::infinity()}, high{-low};

  void add(double value, int axis) {
    low[axis] = std::min(low[axis], value);
    high[axis] = std::max(high[axis], value);
  }
  [[nodiscard]] Vec3 centre() const { return low / 2.0 + high / 2.0; }
  /// Farther than float32 bears: it has 24 bits, of which these are lost.
  [[nodiscard]] bool isFar() const {
    constexpr double kFar = 4;
    const Vec3 size = high - low, from = glm::max(glm::abs(low), glm::abs(high));
    const double largest = std::max({size.x, size.y, size.z});
    return largest > 0 && std::max({from.x, from.y, from.z}) > kFar * largest && std::isfinite(glm::length(from));
  }
};

/// Numbers in a text that are positions: x, y and z in turn, from an axis on.
struct Numbers {
  std::string_view text;
  int firstAxis = 0;
};

/// Calls `take` with each number's word, its value and its axis, up to a word that is no number.
template <class Take>
void eachNumber(const Numbers& numbers, const Take& take) {
  const std::string_view text = numbers.text;
  int axis = numbers.firstAxis;
  for (std::size_t at = 0; (at = text.find_first_not_of(kBetween, at)) != text.npos; axis = (axis + 1) % 3) {
    const std::size_t end = std::min(text.find_first_of(kBetween, at), text.size());
    double value = 0;
    const auto [last, error] = std::from_chars(text.data() + at + (text[at] == '+' ? 1 : 0), text.data() + end, value);
    if (error != std::errc() || last != text.data() + end) return;
    take(text.substr(at, end - at), value, axis);
    at = end;
  }
}

/// All in the text's order.
std::vector<Numbers> numbersIn3mf(std::string_view text) {
  std::vector<Numbers> all;
  eachTag(text, [&](const XmlTag& tag) {
    if (tag.ends || tag.name != "vertex" || attributeIn(tag.inside, "z").empty()) return true;
    std::array<Numbers, 3> own{
        Numbers{attributeIn(tag.inside, "x"), 0}, {attributeIn(tag.inside, "y"), 1}, {attributeIn(tag.inside, "z"), 2}};
    std::sort(own.begin(), own.end(), [](const Numbers& a, const Numbers& b) { return a.text.data() < b.text.data(); });
    all.insert(all.end(), own.begin(), own.end());
    return true;
  });
  return all;
}

std::vector<Numbers> numbersInX3d(std::string_view text) {
  static const std::set<std::string_view> kWithoutPoints{"Box",           "Cone",          "Cylinder", "Sphere",
                                                         "ElevationGrid", "Extrusion",     "Circle2D", "Disk2D",
                                                         "Rectangle2D",   "TriangleSet2D", "Arc2D",    "ArcClose2D"};
  std::vector<Numbers> all;
  bool mayMove = true;
  eachTag(text, [&](const XmlTag& tag) {
    mayMove = mayMove && !kWithoutPoints.contains(tag.name);
    if (!tag.ends && tag.name == "Coordinate") all.push_back({attributeIn(tag.inside, "point")});
    return mayMove;
  });
  return mayMove ? all : std::vector<Numbers>();
}

/// Of each source that an input of positions names.
std::vector<Numbers> numbersInCollada(std::string_view text) {
  std::set<std::string_view> positions;
  eachTag(text, [&](const XmlTag& tag) {
    const std::string_view source = attributeIn(tag.inside, "source");
    if (!tag.ends && tag.name == "input" && attributeIn(tag.inside, "semantic") == "POSITION" &&
        source.starts_with('#')) {
      positions.insert(source.substr(1));
    }
    return true;
  });
  std::vector<Numbers> all;
  bool isInSource = false, arePoints = true;
  eachTag(text, [&](const XmlTag& tag) {
    if (tag.name == "source") isInSource = !tag.ends && positions.contains(attributeIn(tag.inside, "id"));
    if (!isInSource || tag.ends) return true;
    if (tag.name == "float_array") {
      const auto from = static_cast<std::size_t>(tag.inside.data() + tag.inside.size() - text.data()) + 1;
      if (from < text.size()) all.push_back({text.substr(from, text.find('<', from) - from)});
    } else if (tag.name == "accessor") {
      const std::string_view offset = attributeIn(tag.inside, "offset");
      arePoints = arePoints && attributeIn(tag.inside, "stride") == "3" && (offset.empty() || offset == "0");
    }
    return arePoints;
  });
  return arePoints ? all : std::vector<Numbers>();
}

/// Of each "Vertices" that a "PolygonVertexIndex" follows: those of a blend shape are distances.
std::vector<Numbers> numbersInFbx(std::string_view text) {
  std::vector<Numbers> all;
  std::size_t faces = 0;
  for (std::size_t at = 0; (at = text.find("Vertices:", at)) != text.npos;) {
    at += std::string_view("Vertices:").size();
    std::size_t from = text.find_first_not_of(kBetween, at);
    if (from != text.npos && text[from] == '*') from = std::min(text.find("a:", from), text.size() - 2) + 2;
    const std::size_t end = text.find_first_not_of("+-.0123456789eE \t\r\n,", from);
    if (from == text.npos || end == text.npos) break;
    if (faces < end) faces = text.find("PolygonVertexIndex:", end);
    if (faces == text.npos) break;
    if (text.find("Vertices:", end) > faces) all.push_back({text.substr(from, end - from)});
    at = end;
  }
  return all;
}

Vec3 moveNumbers(std::string& file, const std::vector<Numbers>& all) {
  Box box;
  for (const Numbers& numbers : all) {
    eachNumber(numbers, [&](std::string_view, double value, int axis) { box.add(value, axis); });
  }
  if (!box.isFar()) return Vec3(0);
  const Vec3 centre = box.centre();
  std::string moved;
  moved.reserve(file.size());
  const char* taken = file.data();
  for (const Numbers& numbers : all) {
    eachNumber(numbers, [&](std::string_view word, double value, int axis) {
      char text[32];
      char* const end = std::to_chars(text, text + sizeof text, value - centre[axis]).ptr;
      moved.append(taken, word.data()).append(text, static_cast<std::size_t>(end - text));
      taken = word.data() + word.size();
    });
  }
  moved.append(file, static_cast<std::size_t>(taken - file.data()));
  file = std::move(moved);
  return centre;
}

constexpr std::string_view kFbxHead = "Kaydara FBX Binary  ";

/// A binary FBX: records of a name, values and records. Where each ends counts from the file's beginning.
class BinaryFbx {
 public:
  explicit BinaryFbx(std::string_view file) : file_(file) {
    constexpr std::size_t kVersionAt = 23;
    if (file.size() < kVersionAt + 4) return;
    isLarge_ = number(kVersionAt, 4) >= 7500;
    begin_ = kVersionAt + 4;
  }

  /// The box around all positions; nothing where the file is not as it should be.
  std::optional<Box> box() {
    Box box;
    visit_ = [&box](std::vector<double>& values) {
      for (std::size_t i = 0; i < values.size(); ++i) box.add(values[i], static_cast<int>(i % 3));
    };
    return walk() ? std::optional(box) : std::nullopt;
  }
  std::string lessBy(const Vec3& centre) {
    visit_ = [&centre](std::vector<double>& values) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] -= centre[static_cast<int>(i % 3)];
    };
    return walk() ? std::move(out_) : std::string(file_);
  }

 private:
  static constexpr int kDeepest = 100;

  [[nodiscard]] std::uint64_t number(std::size_t at, std::size_t size) const {
    std::uint64_t value = 0;
    std::memcpy(&value, file_.data() + at, size);
    return value;
  }
  [[nodiscard]] std::size_t wide() const { return isLarge_ ? 8 : 4; }

  bool walk() {
    out_.assign(file_.substr(0, begin_));
    std::size_t at = begin_;
    bool ends = false;
    while (begin_ > 0 && !ends) {
      if (!record(at, file_.size(), "", 0, ends)) return false;
    }
    out_.append(file_.substr(at));
    return begin_ > 0;
  }

  /// One record, or the empty one after the last. @param at  Where it begins; afterwards, where it ended.
  bool record(std::size_t& at, std::size_t end, std::string_view parent, int depth, bool& isLast) {
    const std::size_t head = 3 * wide() + 1;
    if (depth > kDeepest || end - at < head) return false;
    const std::uint64_t recordEnd = number(at, wide()), valuesSize = number(at + 2 * wide(), wide());
    const std::size_t nameSize = number(at + 3 * wide(), 1);
    isLast = recordEnd == 0;
    if (isLast) {
      out_.append(file_.substr(at, head));
      at += head;
      return true;
    }
    if (recordEnd > end || recordEnd < at + head + nameSize || valuesSize > recordEnd - at - head - nameSize)
      return false;
    const std::size_t outAt = out_.size();
    const std::string_view name = file_.substr(at + head, nameSize);
    out_.append(file_.substr(at, head + nameSize));
    const std::size_t valuesAt = at + head + nameSize, outValuesAt = out_.size();
    const std::string_view values = file_.substr(valuesAt, valuesSize);
    const bool arePositions = name == "Vertices" && isMesh(parent) && isOfMesh_;
    if (!(arePositions && positions(values))) out_.append(values);
    putNumber(outAt + 2 * wide(), out_.size() - outValuesAt);
    at = valuesAt + valuesSize;
    if (isMesh(name)) isOfMesh_ = file_.substr(at, recordEnd - at).find("PolygonVertexIndex") != file_.npos;
    for (bool last = false; at < recordEnd && !last;) {
      if (!record(at, recordEnd, name, depth + 1, last)) return false;
    }
    if (at != recordEnd) return false;
    putNumber(outAt, out_.size());
    return true;
  }

  static bool isMesh(std::string_view name) { return name == "Geometry" || name == "Model"; }

  void putNumber(std::size_t at, std::uint64_t value) { std::memcpy(out_.data() + at, &value, wide()); }

  /// An array of float64, which is put out unpacked. False: the values are something else.
  bool positions(std::string_view values) {
    constexpr std::size_t kHead = 13;
    if (values.size() < kHead || values[0] != 'd') return false;
    std::uint32_t count = 0, packing = 0, size = 0;
    std::memcpy(&count, values.data() + 1, 4);
    std::memcpy(&packing, values.data() + 5, 4);
    std::memcpy(&size, values.data() + 9, 4);
    const std::string_view bytes = values.substr(kHead);
    std::vector<double> numbers;
    if (size != bytes.size() || std::size_t{count} * sizeof(double) / kMaxInflation > bytes.size()) return false;
    numbers.resize(count);
    const std::size_t all = numbers.size() * sizeof(double);
    if (packing == 0 && all == bytes.size()) {
      std::memcpy(numbers.data(), bytes.data(), all);
    } else if (packing != 1 || libdeflate_zlib_decompress(makeInflater().get(), bytes.data(), bytes.size(),
                                                          numbers.data(), all, nullptr) != LIBDEFLATE_SUCCESS) {
      return false;
    }
    visit_(numbers);
    const std::uint32_t head[]{count, 0, static_cast<std::uint32_t>(all)};
    out_.append(1, 'd').append(reinterpret_cast<const char*>(head), sizeof head);
    out_.append(reinterpret_cast<const char*>(numbers.data()), all);
    return true;
  }

  std::string_view file_;
  std::size_t begin_ = 0;
  bool isLarge_ = false;
  bool isOfMesh_ = false;  ///< The geometry has polygons; those of a blend shape are distances.
  std::function<void(std::vector<double>&)> visit_;
  std::string out_;
};

Vec3 moveBinaryFbx(std::string& file) {
  BinaryFbx fbx(file);
  const auto box = fbx.box();
  if (!box || !box->isFar()) return Vec3(0);
  file = fbx.lessBy(box->centre());
  return box->centre();
}

}  // namespace

Vec3 moveToOrigin(std::string& file, MeshFormat format) {
  switch (format) {
    case MeshFormat::kCollada:
      return moveNumbers(file, numbersInCollada(file));
    case MeshFormat::kX3d:
      return moveNumbers(file, numbersInX3d(file));
    case MeshFormat::k3mf:
      return moveNumbers(file, numbersIn3mf(file));
    case MeshFormat::kFbx:
      return file.starts_with(kFbxHead) ? moveBinaryFbx(file) : moveNumbers(file, numbersInFbx(file));
    default:
      return Vec3(0);
  }
}

}  // namespace haptics
