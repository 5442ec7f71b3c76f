#include "common/wire/checks.h"

#include <cmath>
#include <sstream>

#include "common/wire/convert.h"

namespace haptics {
namespace {

/// Off 1 by more than this is a mistake, not rounding (scene.proto, Quaternion).
constexpr double kRotationLengthTolerance = 1e-3;

/// The shortest text that reads well: 0.1, 1e+06, nan.
std::string text(double number) {
  std::ostringstream out;
  out << number;
  return out.str();
}

Refusal outside(const std::string& field, double value, const std::string& right) {
  return Error{field, "is " + text(value) + "; " + right};
}

Refusal checkCoordinate(double value, const std::string& field) {
  if (std::abs(value) <= kMaxCoordinate_m) return std::nullopt;  // false for NaN
  return outside(field, value, "give metres from -" + text(kMaxCoordinate_m) + " to " + text(kMaxCoordinate_m));
}

Refusal checkShare(float value, const std::string& field) {
  if (value >= 0 && value <= 1) return std::nullopt;
  return outside(field, value, "give a share from 0 to 1");
}

}  // namespace

Refusal checkName(const std::string& name, const std::string& field) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.";
  const std::string right = "a name has 1 to " + std::to_string(kMaxNameLength) + " characters of A-Z a-z 0-9 _ - .";
  if (name.empty()) return Error{field, "is missing; " + right};
  if (name.size() > kMaxNameLength) {
    return Error{field, "has " + std::to_string(name.size()) + " characters; " + right};
  }
  if (name.find_first_not_of(kLetters) != std::string::npos) return Error{field, "has other characters; " + right};
  return std::nullopt;
}

Refusal checkPosition(const v1::Vector3& position, const std::string& field) {
  if (auto bad = checkCoordinate(position.x(), field + ".x")) return bad;
  if (auto bad = checkCoordinate(position.y(), field + ".y")) return bad;
  return checkCoordinate(position.z(), field + ".z");
}

Refusal checkRotation(const v1::Quaternion& rotation, const std::string& field) {
  const double length = std::sqrt(rotation.w() * rotation.w() + rotation.x() * rotation.x() +
                                  rotation.y() * rotation.y() + rotation.z() * rotation.z());
  if (std::abs(length - 1) <= kRotationLengthTolerance) return std::nullopt;
  return Error{field, "has length " + text(length) + "; a rotation is a unit quaternion (w 1 for none)"};
}

Refusal checkStiffness(double stiffness_N_per_m, const std::string& field) {
  if (stiffness_N_per_m > 0 && stiffness_N_per_m <= kMaxStiffness_N_per_m) return std::nullopt;
  return outside(field, stiffness_N_per_m, "give more than 0 and at most " + text(kMaxStiffness_N_per_m) + " N/m");
}

Refusal checkDamping(double damping_Ns_per_m, const std::string& field) {
  if (damping_Ns_per_m >= 0 && damping_Ns_per_m <= kMaxDamping_Ns_per_m) return std::nullopt;
  return outside(field, damping_Ns_per_m, "give 0 to " + text(kMaxDamping_Ns_per_m) + " N s/m");
}

Refusal checkColor(const v1::Color& color, const std::string& field) {
  if (auto bad = checkShare(color.red(), field + ".red")) return bad;
  if (auto bad = checkShare(color.green(), field + ".green")) return bad;
  return checkShare(color.blue(), field + ".blue");
}

Refusal checkLength(double length_m, const std::string& field) {
  if (length_m > 0 && length_m <= kMaxCoordinate_m) return std::nullopt;
  return outside(field, length_m, "give more than 0 and at most " + text(kMaxCoordinate_m) + " m");
}

}  // namespace haptics
