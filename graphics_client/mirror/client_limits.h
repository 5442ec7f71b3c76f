#pragma once

#include <cstddef>

namespace haptics {

/// What a client holds of a server's scene: more than a server of this version ever has. One that sends more is left, as if
/// it had refused.
inline constexpr std::size_t kMaxHeldObjects = 1024;
inline constexpr std::size_t kMaxHeldAssets_bytes = 640U << 20;  ///< Canonical, with those under way.

/// Longest text in which a server describes itself.
inline constexpr std::size_t kMaxServerText_bytes = 1000;

/// What may wait for a server that does not read: an edit of the largest size for each that may be under way, and as much
/// again.
inline constexpr std::size_t kMaxUnsent_bytes = 64U << 20;

}  // namespace haptics
