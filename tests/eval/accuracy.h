#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace haptics::eval {

inline constexpr int kFinestMesh = 12 * 74 * 74;  ///< Triangles, 65,712.

struct AccuracyOptions {
  std::uint64_t seed = 1;
  int finest = kFinestMesh;  ///< No meshes of more triangles; there are some up to 10 million.
  std::string method;        ///< Only this one; all when empty.
  std::filesystem::path out = ".";
};

/// Every method on shapes whose surface is known exactly, by mesh resolution and depth: prints a table for 2 mm, writes
/// DIR/accuracy.json. Fed the inverse way (Ruffaldi et al., Standardized evaluation of haptic rendering systems, 2006):
/// for a point s of the true surface and a traction F the HIP is s - F/k, and the ideal answer is s and F. A run passes
/// when contact holds where it should and nowhere else, on the right side, nearer to the truth than the larger of depth
/// and mean edge. Beside that, by method and mesh: limit cycle and critical stiffness in the servo's loop
/// (closed_loop_rest.h). Throws std::invalid_argument when there is no such method.
/// @return Whether ours passed throughout, came to rest and was where a brute-force proxy on the same mesh is.
[[nodiscard]] bool runAccuracy(const AccuracyOptions& options);

}  // namespace haptics::eval
