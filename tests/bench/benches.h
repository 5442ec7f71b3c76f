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
/// From the device's position to the force in the server's loop, which sleeps between ticks; with and without pre-touch.
void registerServo(std::span<const std::uint32_t> sizes);
/// The database's build, and its size.
void registerBuild(std::span<const std::uint32_t> sizes);

/// Encoding, and the latency of a state and of an edit between threads of one process and over TCP.
void registerProtocol();

}  // namespace haptics::bench
