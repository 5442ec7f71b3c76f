#pragma once

#include <bit>
#include <cstdint>

#include "tests/eval/adapters/haptics_method.h"

// What haptic_eval and a method's process say to each other; README.md has it byte by byte. The processes are on one machine
// whose bytes are in the order of the protocol's.
namespace haptics::eval::adapter {

static_assert(std::endian::native == std::endian::little);

enum class Kind : std::uint32_t { kHello = 1, kLoad, kPlace, kTick, kRefusal };

/// Before each message. An answer has the kind of what it answers, or kRefusal with a text.
struct Head {
  Kind kind;
  std::uint32_t bytes;  ///< Of what follows.
};

/// Followed, in an answer, by "NAME\nVERSION".
struct Hello {
  std::uint32_t abi;
  std::uint32_t abilities;  ///< 0 in a question.
};

/// Followed by a BodyHead for each body, then by the vertices and triangles of each.
struct LoadHead {
  std::uint32_t bodies;
  std::uint32_t reserved;
  double hip_m[3];
};

struct BodyHead {
  std::uint32_t vertices, triangles, isClosed, reserved;
  double stiffness_N_per_m, staticFriction, dynamicFriction, crease_rad;
  haptics_pose pose;
};
static_assert(sizeof(BodyHead) == 104);

/// Of a tick.
struct Answer {
  double force_N[3], ihip_m[3], torque_Nm[3];
  double duration_ns;  ///< Of the method alone; 0: not measured.
  std::uint32_t flags, triangles;
};
static_assert(sizeof(Answer) == 88);

inline constexpr std::uint32_t kMaxAnswer_bytes = 4096;

}  // namespace haptics::eval::adapter
