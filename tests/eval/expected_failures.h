#pragma once

#include <array>
#include <string_view>

namespace haptics::eval {

struct Expectation {
  std::string_view method;
  std::string_view fails;   ///< Scenes, each followed by a space.
  std::string_view either;  ///< The same, where it depends on how the motion falls on the mesh.
};

/// The scenes that each method is expected to fail. What is not named it passes, as ours passes nearly all: that a correct
/// god-object holds nearly everywhere is a finding.
///
/// ours_shaded: shading leaves the contact as it is; what it does to the force S1 to S3, S10, S13 to S15 and S17 measure.
/// ours_float: rounds to 2^-24 of the extent, which a sliver of 1 um may notice (S12), and a force along the floor that
///   is to stay below 1 mN (S2); it takes the wrong side,
///   and goes on inside, where boxes close in (S31) and folds meet (S32).
/// pseudocode_*: as printed, the first contact has no force (S3), the path is not taken in a moving body's frame (S4),
///   neighbours know nothing of other bodies (S2). Closed primitives never leave their first polygon (S1, S6, S7, S10,
///   S11, slivers of S12); open ones stay at a vertex whose neighbours' projections all fall outside (S6, S7, S10, S11,
///   S12, and S1 and S8 when the way leads there).
/// global_closest: has no memory of where it came in: into the other body (S2), through plates (S4, S9), across the
///   medial axis (S8); looks at too many triangles on fans and deep inside (S6, S7); needs an inside (S11).
/// god_object: as published for bodies at rest (S4); goes straight to where a tick ends, not where a slow hand would
///   (S7).
/// god_object_by_rays: loses segments through edges and vertices (S5), and with them contact (S1, S11).
/// finite_proxy_1mm: as god_object (S4, S7), but watertight even where the mesh is not; its radius is a length of its
///   own, whatever the scale (S12).
/// intermediate_plane_*: as global_closest wherever the plane is put anew; between, the plane ends nowhere (S1), is not
///   there (S3, S4), holds what has gone past a knife's edge (S12), and steps when it is put anew (S10).
/// Among long triangles that cross (S21) the published pseudocode, the methods without memory and those without a path that
/// is tested go through walls; a ray test that loses segments, and a first contact without force, now and then.
/// Among 256 boxes that overlap (S22) only ours is judged.
/// Between surfaces that are flush but for rounding they lose the surface (S33 to S35), at once where the HIP is exactly over the
/// seam; the sphere of 1 mm does not fit in, but is of another size where the scene is scaled.
/// All of these know nothing of edits: they begin anew, with the HIP wherever it is (S17; S38, but
/// for global_closest and intermediate_plane_*, which remember no path); nor of bodies that move (S31, S36),
/// nor of samples, so that a block is held where the last one was (S37); take the triangles that a lattice mirrors as they are (S39);
///   nor of a mesh that passes through itself: its faces within have no outside (S32).
/// surface_as_printed: rings on a grating that Eq. (4) alone leaves too stiff for a device (S13); its shading turns the
///   force where the IHIP jumps from facet to facet, and knows no depth that is too deep (S14); it chatters (S15).
/// bump_mapping: the same, and rings more (S13).
/// surface_after_contact: loses the contact of a hand that draws back, for the surface is where it was (S16).
/// springs_between_bodies: as stiff as a tick bears (springStiffness_N_per_m()) is too soft. A stack sinks by more than
///   0.2 mm, leans and falls, also on softer ones (S26). A squeezed brick enters the wall, by up to 0.4 mm, and the hand
///   feels that much less; mostly it slips out of the hand aside, where its surface is nearest (S27). Momentum it keeps to
///   the last digits (S28). Whether one of 32 bodies sinks too deep into the bowl, or gets through, depends on how they
///   fall (S30).
///   What an edit has put into others by more than a tick's way it takes for apart (S40).
/// ours_without_*: what the correction is for; on seams (S33 to S35) whatever brings the IHIP out of its surface in the tick in
///   which a wall is in its way.
///   feature_codes: as pseudocode_closed but for the corrections that it has (S1, S2, S6, S7, S10, S11, S12).
///   pseudonormals: falls out at the bottom of a gash or a pit when the HIP goes about below it (S12).
///   same_tick_search: wherever the tick of first contact is looked at (S3, S4, S5, S7, S9, S11, S12, S31, S32).
///   exit_retest: a comb's next tooth (S3).
///   object_frames: moving bodies (S4, S31, S32).
///   containment: stays inside of what has closed in (S31). It also brings out what the corrections below and above let in,
///     which therefore pass S31 and S32, or nearly so.
///   guard: into the other body (S2), and into the same one where it passes through itself (S32).
///   several_surfaces: does not slide along the other body (S2), nor along the boundaries of bad meshes (S11).
///   budget: fans (S6).
///   scale_free_tolerances: scaled scenes (S12).
///   substeps: is not where a slow hand would be (S7).
///   closed_gaps: segments pass between what is flush or cracked (S33 to S35): of 20 seeds S33 caught 18 with six floors each.
///   gain_clamp: gratings (S13).
///   reprojection: edits of what is touched (S17, S38). turning_over: mirrored bodies (S39). ways_between_samples: a block that
///   jumps from sample to sample (S37). overlaps: bodies that were put into each other stay so (S40).
///   watertight_test: segments through edges and vertices (S5); elsewhere the first contact alone needs a segment, and of 50
///     seeds 5 came in by such a one (S1).
/// P1 to P9 are lost by what loses S33 to S40, of which they are kinds, with these differences. P3: who goes straight to where a
///   tick ends or leaves no polygon that it is on is not held by three walls at once. P6: global_closest and intermediate_plane_*
///   pass, for the nearest place is also the one that has grown; ours_shaded has the force of the smooth ball, and is judged
///   by that of its facets. P9: springs let the slab sink into the seams.
inline constexpr std::array kExpectedFailures{
    Expectation{"ours", "", ""},
    Expectation{"ours_shaded", "P6 ", ""},
    Expectation{"ours_float", "", "S2 S12 S22 S32 S33 S35 P2 "},
    Expectation{"ours_without_feature_codes", "S1 S2 S6 S7 S10 S11 S12 S33 S34 S35 P1 P2 P3 ", "S22 "},
    Expectation{"ours_without_pseudonormals", "S12 ", "S22 "},
    Expectation{"ours_without_same_tick_search", "S3 S4 S5 S7 S9 S11 S12 S33 S34 S35 P1 P2 P3 ", "S21 S22 S31 S32 "},
    Expectation{"ours_without_exit_retest", "S3 ", "S22 "},
    Expectation{"ours_without_object_frames", "S4 S31 S32 S35 S36 S37 P5 ", "S22 "},
    Expectation{"ours_without_containment", "S31 ", "S22 "},
    Expectation{"ours_without_guard", "S2 S21 S33 S35 P1 ", "S22 S32 S34 "},
    Expectation{"ours_without_several_surfaces", "S2 S11 S33 S34 S35 P1 P2 ", "S22 "},
    Expectation{"ours_without_budget", "S6 ", "S22 "},
    Expectation{"ours_without_scale_free_tolerances", "S12 ", "S22 S33 S34 S35 "},
    Expectation{"ours_without_substeps", "S7 ", "S22 "},
    Expectation{"ours_without_watertight_test", "S5 S34 S35 P1 P2 ", "S1 S22 S33 "},
    Expectation{"ours_without_closed_gaps", "S34 S35 P1 P2 ", "S22 S33 "},
    Expectation{"ours_without_reprojection", "S17 S38 P6 ", ""},
    Expectation{"ours_without_turning_over", "S39 P4 ", ""},
    Expectation{"ours_without_ways_between_samples", "S37 ", ""},
    Expectation{"ours_without_overlaps", "", "S40 P7 "},
    Expectation{"ours_without_gain_clamp", "S13 ", ""},
    Expectation{"surface_as_printed", "S13 S14 S15 ", ""},
    Expectation{"bump_mapping", "S13 S14 S15 ", ""},
    Expectation{"surface_after_contact", "S16 ", ""},
    Expectation{"springs_between_bodies", "S26 S27 S40 P7 P9 ", "S30 P8 "},
    Expectation{"pseudocode_closed",
                "S1 S2 S3 S4 S6 S7 S10 S11 S12 S17 S21 S31 S32 S33 S34 S35 S36 S37 S38 S39 P1 P2 P3 P4 P5 P6 ", "S22 "},
    Expectation{"pseudocode_open",
                "S2 S3 S4 S6 S7 S10 S11 S12 S17 S21 S31 S32 S33 S34 S35 S36 S37 S38 S39 P1 P2 P4 P5 P6 ",
                "S1 S8 S22 P3 "},
    Expectation{"global_closest", "S2 S4 S6 S7 S8 S9 S11 S17 S21 S31 S32 S33 S34 S35 S36 S37 S39 P1 P2 P4 P5 ", "S22 "},
    Expectation{"god_object", "S4 S7 S17 S31 S32 S33 S34 S35 S36 S37 S38 S39 P1 P2 P4 P5 P6 ", "S22 "},
    Expectation{"god_object_by_rays", "S1 S4 S5 S7 S11 S17 S31 S32 S33 S34 S35 S36 S37 S38 S39 P1 P2 P4 P5 P6 ",
                "S12 S21 S22 "},
    Expectation{"finite_proxy_1mm", "S4 S7 S12 S17 S31 S32 S35 S36 S37 S38 S39 P3 P6 ", "S22 S33 S34 P1 P2 P5 "},
    Expectation{"intermediate_plane_30Hz",
                "S1 S2 S3 S4 S6 S7 S8 S9 S10 S11 S12 S17 S21 S31 S32 S33 S34 S35 S36 S37 S39 P1 P2 P3 P4 P5 ", "S22 "},
    Expectation{"intermediate_plane_100Hz",
                "S1 S2 S3 S4 S6 S7 S8 S9 S10 S11 S12 S17 S21 S31 S32 S33 S34 S35 S36 S37 S39 P1 P2 P3 P4 P5 ", "S22 "},
};

}  // namespace haptics::eval
