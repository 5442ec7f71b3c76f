#pragma once

#include <filesystem>
#include <optional>

#include "tests/eval/fuzz/contact_motion.h"
#include "tests/eval/fuzz/contact_tally.h"

namespace haptics::eval {

/// The first tick of a motion that fails.
struct ContactFinding {
  ContactFailure failure;
  std::size_t frame = 0;  ///< Of the motion.
  double inside_m = 0;
};

/// Runs the contact core along a motion. Counts into `tally` unless it is null.
/// @return The first failure, or the first of one kind.
[[nodiscard]] std::optional<ContactFinding> findFailure(const ContactMotion& motion, ContactTally* tally = nullptr,
                                                        std::optional<ContactFailure> kind = std::nullopt);

/// Leaves out bodies and ticks as long as what is left fails in the same way.
[[nodiscard]] ContactMotion reduced(ContactMotion motion, const ContactFinding& finding);

/// Writes motion.csv (tick, the HIP's x y z, then of every body the quaternion's w x y z and the position), body<i>.obj
/// and, where the mesh is not closed, gap<i>.obj with what would close it, of a plate upper<i>.obj, of a FlatTop flat.csv (its
/// pose in the first body, least x and y, largest x and y). Nothing is rounded. Throws std::runtime_error
/// naming the file that cannot be written.
void writeMotion(const ContactMotion& motion, const std::filesystem::path& folder);

/// What writeMotion() wrote. Throws std::runtime_error naming what is missing or wrong.
[[nodiscard]] ContactMotion readMotion(const std::filesystem::path& folder);

}  // namespace haptics::eval
