#pragma once

#include <optional>
#include <string>

#include "common/error/error.h"
#include "haptics/v1/scene.pb.h"

// Checks that edits and announced states share. Nothing: it may pass; otherwise the error for `field`.
namespace haptics {

using Refusal = std::optional<Error>;

/// The shortest text that reads well: 0.1, 1e+06, nan.
[[nodiscard]] std::string numberText(double number);
/// "is 7; " and what would be right.
[[nodiscard]] Error outside(const std::string& field, double value, const std::string& right);

struct Range {
  double least, most;
  const char* unit = "";  ///< " m"
};
[[nodiscard]] Refusal checkRange(double value, const Range& range, const std::string& field);
/// What is to be more than 0, and enough to mean something: `range.least` is where it ceases to.
[[nodiscard]] Refusal checkAbove0(double value, const Range& range, const std::string& field);
/// Length 1, off by at most 1e-3.
[[nodiscard]] Refusal checkUnitVector(const v1::Vector3& vector, const std::string& field);
/// A relative path without steps upwards. That it stays below the folder, whatever links lie there, is for the server
/// to see when it opens it.
[[nodiscard]] Refusal checkFilePath(const std::string& path, const std::string& field);

[[nodiscard]] Refusal checkName(const std::string& name, const std::string& field);
/// Finite, and no coordinate beyond kMaxCoordinate_m.
[[nodiscard]] Refusal checkPosition(const v1::Vector3& position, const std::string& field);
/// Finite, and a length that is off 1 by at most 1e-3.
[[nodiscard]] Refusal checkRotation(const v1::Quaternion& rotation, const std::string& field);
/// Within what scene.proto says of it.
/// \param scalar  A number of v1::Material.
[[nodiscard]] Refusal checkScalar(double value, const google::protobuf::FieldDescriptor& scalar,
                                  const std::string& field);
[[nodiscard]] Refusal checkColor(const v1::Color& color, const std::string& field);
/// A length: kMinLength_m to kMaxCoordinate_m.
[[nodiscard]] Refusal checkLength(double length_m, const std::string& field);
/// Each side a length.
[[nodiscard]] Refusal checkSize(const v1::Vector3& size_m, const std::string& field);
[[nodiscard]] Refusal checkVector(const v1::Vector3& vector, const Range& range, const std::string& field);

}  // namespace haptics
