#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace haptics {

/// The bytes of a file that a file includes, by the name that it has there; nothing where it is to be left out.
using IncludeReader = std::function<std::optional<std::string>(const std::string& name)>;

/// A file's bytes that repeat shapes (USE, Array, MultipleCopy), or ask for round ones, make no more triangles, and lead to no
/// more nodes, than this and one for each byte. So many are imported within 1 GB.
inline constexpr std::size_t kMaxOfFewBytes = 2'000'000;

}  // namespace haptics
