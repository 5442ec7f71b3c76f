#pragma once

#include <optional>
#include <string>

#include "common/error/error.h"
#include "haptics/v1/scene.pb.h"

// Checks that edits and announced states share. Nothing: it may pass; otherwise the error for `field`.
namespace haptics {

using Refusal = std::optional<Error>;

[[nodiscard]] Refusal checkName(const std::string& name, const std::string& field);
/// Finite, and no coordinate beyond kMaxCoordinate_m.
[[nodiscard]] Refusal checkPosition(const v1::Vector3& position, const std::string& field);
/// Finite, and a length that is off 1 by at most 1e-3.
[[nodiscard]] Refusal checkRotation(const v1::Quaternion& rotation, const std::string& field);
[[nodiscard]] Refusal checkStiffness(double stiffness_N_per_m, const std::string& field);
[[nodiscard]] Refusal checkDamping(double damping_Ns_per_m, const std::string& field);
[[nodiscard]] Refusal checkColor(const v1::Color& color, const std::string& field);
/// A length: finite, > 0 and at most kMaxCoordinate_m.
[[nodiscard]] Refusal checkLength(double length_m, const std::string& field);

}  // namespace haptics
