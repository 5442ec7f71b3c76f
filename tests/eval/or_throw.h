#pragma once

#include <stdexcept>
#include <type_traits>
#include <utility>

#include "common/error/error.h"

namespace haptics::eval {

/// What a result holds; std::runtime_error with its reason where it was refused.
template <class Value>
Value orThrow(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().text());
  if constexpr (!std::is_void_v<Value>) return std::move(*result);
}

}  // namespace haptics::eval
