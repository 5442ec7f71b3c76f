#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace haptics {

/// Why an input was refused, in words for the person who sent it.
struct Error {
  std::string field;   ///< Path of the bad field or file, e.g. "operations[2].add.mesh.file"; may be empty.
  std::string reason;  ///< What is wrong and what would be right.

  [[nodiscard]] std::string text() const { return field.empty() ? reason : field + ": " + reason; }
  /// The same error seen from one level farther out: prefix + field.
  [[nodiscard]] Error within(const std::string& prefix) && { return {prefix + field, std::move(reason)}; }
};

/// The outcome of handling untrusted input.
template <class T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> refused(std::string field, std::string reason) {
  return tl::unexpected<Error>(Error{std::move(field), std::move(reason)});
}

}  // namespace haptics
