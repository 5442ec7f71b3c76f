#pragma once

#include <cstddef>

#include "common/scene/scene.h"

namespace haptics {

/// Bytes of memory that a decoded edit takes, allocators' overhead aside.
[[nodiscard]] std::size_t memoryOf_bytes(const Transaction& transaction) noexcept;

}  // namespace haptics
