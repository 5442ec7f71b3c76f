#pragma once

#include <array>
#include <string_view>

namespace haptics::eval {

struct Expectation {
  std::string_view method;
  std::string_view fails;   ///< Scenes, each followed by a space.
  std::string_view either;  ///< The same, where it depends on how the motion falls on the mesh.
};

/// The scenes that each baseline is expected to fail. What is not named it passes, as ours passes all: that a correct
/// god-object holds nearly everywhere is a finding.
///
/// No baseline knows of edits: it begins anew, with the HIP wherever it is (S17).
/// pseudocode_*: as printed, the first contact has no force (S3), the path is not taken in a moving body's frame (S4),
///   neighbours know nothing of other bodies (S2). Closed primitives never leave their first polygon (S1, S6, S7, S10,
///   S11, slivers of S12); open ones stay at a vertex whose neighbours' projections all fall outside (S6, S7, S10, S11,
///   S12, and S1 and S8 when the way leads there).
/// global_closest: has no memory of where it came in: into the other body (S2), through plates (S4, S9), across the
///   medial axis (S8); looks at too many triangles on fans and deep inside (S6, S7); needs an inside (S11).
/// god_object: as published for bodies at rest (S4).
/// god_object_by_rays: loses segments through edges and vertices (S5), and with them contact (S1, S11).
/// finite_proxy_1mm: as published for bodies at rest (S4); its radius is a length of its own, whatever the scale (S12).
///   Everywhere else it is a god-object that is also watertight where the mesh is not.
/// intermediate_plane_*: as global_closest wherever the plane is put anew; between, the plane ends nowhere (S1), is not
///   there (S3, S4), and steps when it is put anew (S10).
inline constexpr std::array kExpectedFailures{
    Expectation{"ours", "", ""},
    Expectation{"pseudocode_closed", "S1 S2 S3 S4 S6 S7 S10 S11 S12 S17 ", ""},
    Expectation{"pseudocode_open", "S2 S3 S4 S6 S7 S10 S11 S12 S17 ", "S1 S8 "},
    Expectation{"global_closest", "S2 S4 S6 S7 S8 S9 S11 S17 ", ""},
    Expectation{"god_object", "S4 S17 ", ""},
    Expectation{"god_object_by_rays", "S1 S4 S5 S11 S17 ", "S12 "},
    Expectation{"finite_proxy_1mm", "S4 S12 S17 ", ""},
    Expectation{"intermediate_plane_30Hz", "S1 S2 S3 S4 S6 S7 S8 S9 S10 S11 S17 ", ""},
    Expectation{"intermediate_plane_100Hz", "S1 S2 S3 S4 S6 S7 S8 S9 S10 S11 S17 ", ""},
};

}  // namespace haptics::eval
