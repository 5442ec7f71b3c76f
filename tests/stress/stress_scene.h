#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "common/scene/scene.h"
#include "haptics/v1/scene.pb.h"

// The objects of the test: what a hand explores, a counter that all editors increment, and a mark for each editor that
// says which of its edits a commit holds. Counter and marks are out of the hand's reach.
namespace haptics::stress {

inline constexpr const char* kCounter = "counter";
inline constexpr double kMetresPerCount = 1e-6;

[[nodiscard]] inline std::string markName(int client) { return "mark" + std::to_string(client); }

/// The scene file, for `clients` editors.
[[nodiscard]] std::string sceneText(int clients);

[[nodiscard]] inline std::uint64_t countOf(const ObjectRecord& counter) {
  return static_cast<std::uint64_t>(std::llround(counter.pose.position.x / kMetresPerCount));
}

/// An edit of a client: (life, number) is its own for ever, also across the client's death.
struct EditName {
  std::uint64_t life = 0, number = 0;
  auto operator<=>(const EditName&) const = default;
};
[[nodiscard]] inline EditName editNameOf(const ObjectRecord& mark) {
  return {static_cast<std::uint64_t>(std::llround(mark.pose.position.x / kMetresPerCount)),
          static_cast<std::uint64_t>(std::llround(mark.pose.position.y / kMetresPerCount))};
}

/// Sets the client's mark; `counter`, as the client knows it: adds 1 to it, provided that nobody did in between.
[[nodiscard]] v1::Transaction makeEdit(int client, EditName name, const ObjectRecord* counter);

}  // namespace haptics::stress
