#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <string_view>

namespace haptics {

/// Which of a file's meshes is taken: its name, or its number from 0; empty: all. Trivially copyable, for a process to hand it
/// to another.
class PartName {
 public:
  static constexpr std::size_t kLongest = 1023;  ///< Bytes; of those that Assimp reads (aiString).

  PartName() = default;
  /// Cut off after kLongest.
  explicit PartName(std::string_view name) { name.copy(bytes_.data(), kLongest); }

  [[nodiscard]] std::string_view text() const {
    const auto end = std::find(bytes_.begin(), bytes_.end(), '\0');
    return {bytes_.data(), static_cast<std::size_t>(end - bytes_.begin())};
  }
  auto operator<=>(const PartName&) const = default;

 private:
  std::array<char, kLongest + 1> bytes_{};
};

}  // namespace haptics
