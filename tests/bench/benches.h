#pragma once

#include <cstdint>
#include <span>

/// What haptic_bench measures; `sizes` are segments of the spheres (scenes.h).
namespace haptics::bench {

/// The contact tick hot and cold, the search alone, and the whole step.
void registerContact(std::span<const std::uint32_t> sizes);
/// The contact tick's other phases. A file of their own: beside them the compiler inlines less of the search.
void registerPhases(std::span<const std::uint32_t> sizes);
/// The same questions put to Embree, CGAL and a god-object.
void registerPeers(std::span<const std::uint32_t> sizes);
/// From the device's position to the force in the server's loop, which sleeps between ticks; with and without the cache warmer.
void registerServo(std::span<const std::uint32_t> sizes);
/// What an effect adds to the step in the open.
void registerEffects();
/// Tools of many points, ours and a point shell over a distance field.
void registerTools();
/// The database's build, and its size.
void registerBuild(std::span<const std::uint32_t> sizes);

/// Encoding, and the latency of a state and of an edit between threads of one process and over TCP.
void registerProtocol();

/// The paper's two structures (section 2, Figure 1) with the same scene: memory, missed ticks, and the time from a commit
/// until the viewer's database holds its mesh, from where both draw alike.
void registerStructures(std::span<const std::uint32_t> sizes);
/// The option by which a benchmark of one structure runs it in a process of its own; its arguments are those of
/// runStructure(), which returns the exit code.
inline constexpr const char* kStructure = "--structure";
[[nodiscard]] int runStructure(const char* structure, const char* segments);

}  // namespace haptics::bench
