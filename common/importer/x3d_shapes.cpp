#include "common/importer/x3d_shapes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/maths/vec.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

constexpr int kSides = 64;

/// A shape's fields; after the first fault, what it gives means nothing.
class Fields {
 public:
  Fields(std::string_view element, std::string_view attributes) : element_(element), attributes_(attributes) {}

  [[nodiscard]] bool isTrue(std::string_view name) const { return !isFalse(attributes_, name); }

  [[nodiscard]] double length(std::string_view name, double instead) {
    const auto words = wordsIn(attributeIn(attributes_, name));
    const auto value = words.empty() ? instead : numberOf<double>(words.front());
    if (value && *value >= 0 && std::isfinite(*value)) return *value;
    fail(name, "is " + inQuotes(attributeIn(attributes_, name)) + "; it is a number from 0");
    return 0;
  }

  [[nodiscard]] std::size_t count(std::string_view name) {
    const auto words = wordsIn(attributeIn(attributes_, name));
    const auto value = words.empty() ? std::size_t{0} : numberOf<std::size_t>(words.front());
    if (value) return *value;
    fail(name, "is " + inQuotes(words.front()) + "; it is a number from 0");
    return 0;
  }

  /// As many as are a multiple of `each`, which is their least number.
  [[nodiscard]] std::vector<double> numbers(std::string_view name, std::size_t each, std::string_view instead) {
    const std::string_view own = attributeIn(attributes_, name);
    std::vector<double> all;
    for (const std::string_view word : wordsIn(own.empty() ? instead : own)) {
      const auto number = numberOf<double>(word);
      if (!number || !std::isfinite(*number)) fail(name, "has " + inQuotes(word) + " where a number should be");
      all.push_back(number.value_or(0));
    }
    if (all.size() % each != 0) {
      fail(name, "has " + std::to_string(all.size()) + " numbers, which is no multiple of " + std::to_string(each));
    }
    all.resize(std::max(all.size() / each, std::size_t{1}) * each);
    return all;
  }

  void fail(std::string_view name, const std::string& why) {
    const char* const article = element_.starts_with('E') ? "has an " : "has a ";
    if (fault_.empty()) fault_ = article + std::string(element_) + " whose " + std::string(name) + ' ' + why;
  }
  [[nodiscard]] const std::string& fault() const { return fault_; }

 private:
  std::string fault_;
  std::string_view element_, attributes_;
};

class Faces {
 public:
  explicit Faces(bool isClockwise = false) : isClockwise_(isClockwise) {}

  void addPoint(const Vec3& at) {
    for (int axis = 0; axis < 3; ++axis) {
      char text[32];
      points_.append(text, std::to_chars(text, text + sizeof text, at[axis]).ptr).append(1, ' ');
    }
  }
  void add(std::vector<std::size_t> corners) {
    if (isClockwise_) std::reverse(corners.begin() + 1, corners.end());
    for (const std::size_t corner : corners) faces_.append(std::to_string(corner)).append(1, ' ');
    faces_ += "-1 ";
  }
  [[nodiscard]] std::string text() const {
    return " coordIndex=\"" + faces_ + "\"><Coordinate point=\"" + points_ + "\"/>";
  }

 private:
  bool isClockwise_;
  std::string faces_, points_;
};

/// Around the y axis.
Faces roundFaces(Fields& fields, bool isCone) {
  const double bottom = fields.length(isCone ? "bottomRadius" : "radius", 1), top = isCone ? 0 : bottom;
  const double height = fields.length("height", 2);
  Faces faces;
  std::vector<std::size_t> below, above;
  for (std::size_t i = 0; i < kSides; ++i) {
    const double angle = -2 * std::numbers::pi * static_cast<double>(i) / kSides;
    const Vec3 out(std::cos(angle), 0, std::sin(angle));
    faces.addPoint(bottom * out - Vec3(0, height / 2, 0));
    faces.addPoint(top * out + Vec3(0, height / 2, 0));
    below.insert(below.begin(), 2 * i);
    above.push_back(2 * i + 1);
    const std::size_t next = (i + 1) % kSides;
    if (!fields.isTrue("side")) continue;
    if (isCone) {
      faces.add({2 * i, 2 * next, 2 * i + 1});
    } else {
      faces.add({2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
    }
  }
  if (fields.isTrue("bottom")) faces.add(below);
  if (!isCone && fields.isTrue("top")) faces.add(above);
  return faces;
}

Faces disk(Fields& fields) {
  const double outer = fields.length("outerRadius", 1), inner = fields.length("innerRadius", 0);
  if (inner > outer) fields.fail("innerRadius", "is larger than its outerRadius");
  Faces faces;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kSides;
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    faces.addPoint(outer * out);
    faces.addPoint(inner * out);
    all.push_back(2 * i);
    const std::size_t next = (i + 1) % kSides;
    if (inner > 0 && inner < outer) faces.add({2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
  }
  if (inner == 0) faces.add(all);
  return faces;
}

Faces elevations(Fields& fields) {
  const std::size_t across = fields.count("xDimension"), along = fields.count("zDimension");
  const std::vector<double> heights = fields.numbers("height", 1, "0");
  if (along > 0 && across > heights.size() / along) {
    fields.fail("height", "has " + std::to_string(heights.size()) + " numbers; it is " + std::to_string(across) +
                              " times " + std::to_string(along));
    return Faces();
  }
  const double x = fields.length("xSpacing", 1), z = fields.length("zSpacing", 1);
  Faces faces(!fields.isTrue("ccw"));
  for (std::size_t j = 0; j < along; ++j) {
    for (std::size_t i = 0; i < across; ++i) {
      const std::size_t at = j * across + i;
      faces.addPoint({x * static_cast<double>(i), heights[at], z * static_cast<double>(j)});
      if (i > 0 && j > 0) faces.add({at - across - 1, at - 1, at, at - across});
    }
  }
  return faces;
}

/// The axes of a cross section at each point of a spine: ISO/IEC 19775-1, 13.3.5.4.
std::vector<glm::dmat3> alongSpine(const std::vector<Vec3>& spine, bool isClosed) {
  const std::size_t count = spine.size();
  std::vector<Vec3> ys(count), zs(count);
  std::size_t firstBend = count;
  for (std::size_t i = 0; i < count; ++i) {
    const bool isFirst = i == 0, isLast = i + 1 == count;
    const Vec3& before = isFirst ? spine[isClosed ? count - 2 : 0] : spine[i - 1];
    const Vec3& after = isLast ? spine[isClosed ? 1 : count - 1] : spine[i + 1];
    ys[i] = after - before;
    zs[i] = glm::cross(after - spine[i], before - spine[i]);
    // Of numbers that are rounded to float32.
    if (glm::length(zs[i]) <= 1e-6 * glm::length(after - spine[i]) * glm::length(before - spine[i])) zs[i] = Vec3(0);
    if (zs[i] != Vec3(0) && firstBend == count) firstBend = i;
  }
  std::vector<glm::dmat3> axes;
  if (firstBend == count) {  // straight
    Vec3 direction(0, 1, 0);
    for (const Vec3& y : ys) {
      if (glm::length(y) > 0) direction = glm::normalize(y);
    }
    const Vec3 axis = glm::cross(Vec3(0, 1, 0), direction);
    const bool isDown = direction.y < -1 + 1e-12;
    const glm::dquat turn = glm::normalize(isDown ? glm::dquat(0, 0, 0, 1) : glm::dquat(1 + direction.y, axis));
    return std::vector<glm::dmat3>(count, glm::mat3_cast(turn));
  }
  Vec3 y = ys[firstBend], z = zs[firstBend];
  for (std::size_t i = 0; i < count; ++i) {
    if (glm::length(ys[i]) > 0) y = ys[i];
    if (zs[i] != Vec3(0)) z = glm::dot(zs[i], z) < 0 ? -zs[i] : zs[i];
    const Vec3 up = glm::normalize(y), x = glm::normalize(glm::cross(up, z));
    axes.emplace_back(x, up, glm::cross(x, up));
  }
  return axes;
}

Faces extrusion(Fields& fields) {
  const auto section = fields.numbers("crossSection", 2, "1 1 1 -1 -1 -1 -1 1 1 1");
  const auto spineNumbers = fields.numbers("spine", 3, "0 0 0 0 1 0");
  const auto scale = fields.numbers("scale", 2, "1 1");
  const auto turns = fields.numbers("orientation", 4, "0 0 1 0");
  std::vector<Vec3> spine;
  for (std::size_t i = 0; i < spineNumbers.size(); i += 3) {
    spine.emplace_back(spineNumbers[i], spineNumbers[i + 1], spineNumbers[i + 2]);
  }
  std::size_t around = section.size() / 2;
  if (spine.size() < 2) fields.fail("spine", "has fewer than two points");
  if (around < 2) fields.fail("crossSection", "has fewer than two points");
  if (!fields.fault().empty()) return Faces();
  const bool isClosed = spine.size() > 2 && spine.front() == spine.back();
  const bool isRound = around > 2 && section[0] == section[section.size() - 2] && section[1] == section.back();
  around -= isRound ? 1 : 0;
  const std::size_t rings = spine.size();
  const auto axes = alongSpine(spine, isClosed);
  Faces faces(!fields.isTrue("ccw"));
  for (std::size_t ring = 0; ring < rings; ++ring) {
    const std::size_t s = std::min(2 * ring, scale.size() - 2), t = std::min(4 * ring, turns.size() - 4);
    const Vec3 axis(turns[t], turns[t + 1], turns[t + 2]);
    const glm::dquat turn =
        glm::length(axis) > 0 ? glm::angleAxis(turns[t + 3], glm::normalize(axis)) : glm::dquat(1, 0, 0, 0);
    for (std::size_t k = 0; k < around; ++k) {
      const Vec3 own(section[2 * k] * scale[s], 0, section[2 * k + 1] * scale[s + 1]);
      faces.addPoint(spine[ring] + axes[ring] * (turn * own));
    }
  }
  std::vector<std::size_t> first, last;
  for (std::size_t k = 0; k < around; ++k) {
    first.insert(first.begin(), k);
    last.push_back((rings - 1) * around + k);
    const std::size_t next = (k + 1) % around;
    if (next == 0 && !isRound) continue;
    for (std::size_t ring = 0; ring + 1 < rings; ++ring) {
      const std::size_t low = ring * around, high = low + around;
      faces.add({low + k, low + next, high + next, high + k});
    }
  }
  if (!isClosed && around > 2 && fields.isTrue("beginCap")) faces.add(first);
  if (!isClosed && around > 2 && fields.isTrue("endCap")) faces.add(last);
  return faces;
}

}  // namespace

bool isMadeOfFaces(std::string_view element) {
  constexpr std::string_view kMade[] = {"Cone", "Cylinder", "Disk2D", "ElevationGrid", "Extrusion"};
  return isOneOf(kMade, element);
}

Result<std::string> facesOfX3dShape(std::string_view element, std::string_view attributes) {
  Fields fields(element, attributes);
  const Faces faces = element == "Disk2D"          ? disk(fields)
                      : element == "ElevationGrid" ? elevations(fields)
                      : element == "Extrusion"     ? extrusion(fields)
                                                   : roundFaces(fields, element == "Cone");
  if (!fields.fault().empty()) return refused("", fields.fault());
  return faces.text();
}

}  // namespace haptics
