#include "common/wire/checks.h"

#include <google/protobuf/descriptor.h>

#include <cmath>
#include <sstream>

#include "common/wire/convert.h"
#include "common/wire/parts.h"
#include "haptics/v1/options.pb.h"

namespace haptics {
namespace {

/// Off 1 by more than this is a mistake, not rounding (scene.proto, Quaternion and FourierTerm).
constexpr double kUnitLengthTolerance = 1e-3;

Refusal checkCoordinate(double value, const std::string& field) {
  if (std::abs(value) <= kMaxCoordinate_m) return std::nullopt;  // false for NaN
  return outside(field, value,
                 "give metres from -" + numberText(kMaxCoordinate_m) + " to " + numberText(kMaxCoordinate_m));
}

Refusal checkShare(float value, const std::string& field) {
  if (value >= 0 && value <= 1) return std::nullopt;
  return outside(field, value, "give a share from 0 to 1");
}

template <class Check>
Refusal checkEach(const v1::Vector3& v, const std::string& field, Check check) {
  for (const auto& [value, axis] : {std::pair{v.x(), ".x"}, {v.y(), ".y"}, {v.z(), ".z"}}) {
    if (auto bad = check(value, field + axis)) return bad;
  }
  return std::nullopt;
}

}  // namespace

std::string numberText(double number) {
  std::ostringstream out;
  out << number;
  return out.str();
}

Error outside(const std::string& field, double value, const std::string& right) {
  return {field, "is " + numberText(value) + "; " + right};
}

Refusal checkRange(double value, const Range& range, const std::string& field) {
  if (value >= range.least && value <= range.most) return std::nullopt;  // false for NaN
  return outside(field, value, "give " + numberText(range.least) + " to " + numberText(range.most) + range.unit);
}

Refusal checkAbove0(double value, const Range& range, const std::string& field) {
  if (value >= range.least && value <= range.most) return std::nullopt;
  if (value > 0 && value < range.least)
    return outside(field, value,
                   "give at least " + numberText(range.least) + range.unit + ": less has no effect that could be felt");
  return outside(field, value, "give more than 0 and at most " + numberText(range.most) + range.unit);
}

Refusal checkUnitVector(const v1::Vector3& vector, const std::string& field) {
  const double length = glm::length(vectorFrom(vector));
  if (std::abs(length - 1) <= kUnitLengthTolerance) return std::nullopt;
  return Error{field, "has length " + numberText(length) + "; a direction has length 1"};
}

Refusal checkFilePath(const std::string& path, const std::string& field) {
  if (path.empty()) return Error{field, "is empty; give a path below the server's asset folder"};
  if (path.size() > kMaxPathLength) {
    return Error{field, "has more than " + std::to_string(kMaxPathLength) + " characters"};
  }
  if (path.find('\0') != std::string::npos) return Error{field, "holds a zero byte"};
  if (path.front() == '/') return Error{field, "is absolute; give a path below the server's asset folder"};
  if (("/" + path + "/").find("/../") != std::string::npos) {
    return Error{field, "leaves the server's asset folder by \"..\""};
  }
  return std::nullopt;
}

Refusal checkName(const std::string& name, const std::string& field) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.";
  const std::string right = "a name has 1 to " + std::to_string(kMaxNameLength) + " characters of A-Z a-z 0-9 _ - .";
  if (name.empty()) return Error{field, "is missing; " + right};
  if (name.size() > kMaxNameLength) {
    return Error{field, "has " + std::to_string(name.size()) + " characters; " + right};
  }
  if (name.find_first_not_of(kLetters) != std::string::npos)
    return Error{field, "has a character that no name has; " + right};
  return std::nullopt;
}

Refusal checkPosition(const v1::Vector3& position, const std::string& field) {
  return checkEach(position, field, checkCoordinate);
}

Refusal checkRotation(const v1::Quaternion& rotation, const std::string& field) {
  const double length = glm::length(rotationFrom(rotation));
  if (std::abs(length - 1) <= kUnitLengthTolerance) return std::nullopt;
  return Error{field, "has length " + numberText(length) + "; a rotation is a unit quaternion (w 1 for none)"};
}

Refusal checkScalar(double value, const google::protobuf::FieldDescriptor& scalar, const std::string& field) {
  const v1::Scalar& says = scalar.options().GetExtension(v1::scalar);
  const std::string unit = " " + says.unit();
  const Range range{says.least(), says.most(), unit.c_str()};
  return range.least > 0 ? checkAbove0(value, range, field) : checkRange(value, range, field);
}

Refusal checkColor(const v1::Color& color, const std::string& field) {
  if (auto bad = checkShare(color.red(), field + ".red")) return bad;
  if (auto bad = checkShare(color.green(), field + ".green")) return bad;
  return checkShare(color.blue(), field + ".blue");
}

Refusal checkLength(double length_m, const std::string& field) {
  return checkAbove0(length_m, {kMinLength_m, kMaxCoordinate_m, " m"}, field);
}

Refusal checkSize(const v1::Vector3& size_m, const std::string& field) { return checkEach(size_m, field, checkLength); }

Refusal checkVector(const v1::Vector3& vector, const Range& range, const std::string& field) {
  return checkEach(vector, field,
                   [&range](double value, const std::string& at) { return checkRange(value, range, at); });
}

}  // namespace haptics
