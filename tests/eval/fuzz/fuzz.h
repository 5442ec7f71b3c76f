#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "tests/eval/fuzz/contact_scene.h"

namespace haptics::eval {

struct FuzzOptions {
  std::uint64_t seed = 1;  ///< Of the first scene; the others have the seeds that follow.
  std::uint64_t scenes = 1000;
  std::optional<bool> moving;           ///< Only scenes whose bodies move, or rest; else by turns.
  std::optional<double> speed_m_per_s;  ///< Top speed of the HIP; else 1 and 4 by turns.
  std::optional<ContactWorld> world;    ///< Only such ones; else all by turns.
};

/// The contact core among random bodies, judged in every tick by winding numbers. Prints a table, writes DIR/fuzz.json and
/// for the first findings, reduced to what they need, DIR/fuzz-<failure>-<seed>/. Ends in order on Ctrl-C.
/// @return Whether nothing was found.
[[nodiscard]] bool runFuzzContact(const FuzzOptions& options, const std::filesystem::path& out);

/// The step under a HIP that rests while the scene is edited, judged by EditJudge. Prints a table by the kind of edit and
/// the number of objects; writes as runFuzzContact() does.
/// @return Whether nothing was found.
[[nodiscard]] bool runFuzzEdits(const FuzzOptions& options, const std::filesystem::path& out);

/// Servo loop, builder and flight recorder while random edits come (LiveWorld), 20 s of virtual time each: does the recording
/// replay bit for bit, from its start and from each state in it to the next? Writes DIR/fuzz.json, and the recording of what
/// does not as DIR/replay-live-<seed>.haptics.
/// @return Whether all do.
[[nodiscard]] bool runFuzzReplayLive(const FuzzOptions& options, const std::filesystem::path& out);

/// A World whose bodies are driven by moveKinematic(), in every tick or by samples that come less often, judged in every tick
/// by winding numbers where the bodies are by then, and by stiffness times the IHIP's distance; and every so often by whether the
/// IHIP is in equilibrium. Writes DIR/fuzz.json.
/// @return Whether nothing was found.
[[nodiscard]] bool runFuzzStream(const FuzzOptions& options, const std::filesystem::path& out);

/// Boxes that the step moves, stacked, let fall, put into or beside each other, judged by separating axes, statics and energy:
/// is one deep in another for long, does what stands fall, is what floats pulled? Writes DIR/fuzz.json.
/// @return Whether nothing was found.
[[nodiscard]] bool runFuzzBodies(const FuzzOptions& options, const std::filesystem::path& out);

/// Edits that are accepted though their numbers are zero, denormal, huge or none, each followed by ticks of a hand, and by
/// lattices that bring objects to a point, line or plane: is every force finite? Made for builds with sanitizers. Writes
/// DIR/fuzz.json.
/// @return Whether nothing was found.
[[nodiscard]] bool runFuzzDeformedEdits(const FuzzOptions& options, const std::filesystem::path& out);

/// Edits of any size, from a pose to a thousand meshes: does what each takes of the processor and of memory keep to its
/// price, are nine of ten prices of accepted ones above 0.1 s within ten times that, and does what is cancelled end at once? Writes DIR/fuzz.json, DIR/prices.csv.
/// @return Whether that is so.
[[nodiscard]] bool runFuzzPrices(const FuzzOptions& options, const std::filesystem::path& out);

/// Random closed tools in the hand of a World, led among random bodies, at rest and driven: every seventh tick is judged by
/// winding numbers at all vertices of the tool's mesh, whatever points of it are followed. Writes DIR/fuzz.json.
/// @return Whether none was deeper than 10 um.
[[nodiscard]] bool runFuzzTools(const FuzzOptions& options, const std::filesystem::path& out);

/// What runFuzzContact() or runFuzzEdits() wrote into a folder, again; writes DIR/fuzz.json.
/// @return Whether it does not fail any more. Throws std::runtime_error when the folder holds no recording.
[[nodiscard]] bool runFuzzReplay(const std::filesystem::path& folder, const std::filesystem::path& out);

}  // namespace haptics::eval
