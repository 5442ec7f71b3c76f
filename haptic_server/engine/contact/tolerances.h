#pragma once

namespace haptics {

/// Fraction of a triangle's size (root of twice its area) that the HIP advances per step while several surfaces hold
/// the IHIP, so that the solver follows the path that a slow hand would take. Larger jumps over creases; smaller costs
/// time.
inline constexpr double kStepFraction = 0.5;
/// Least such step, as a fraction of the tick.
inline constexpr double kMinShortStep = 0x1p-4;
/// Is a motion of the HIP (squared, m^2) no more than a step over a triangle (square of twice its area, m^4)?
[[nodiscard]] constexpr bool inOneStep(double squaredStep, double squaredTwiceArea) noexcept {
  constexpr double kFraction2 = kStepFraction * kStepFraction;
  return squaredStep * squaredStep <= kFraction2 * kFraction2 * squaredTwiceArea;
}
/// Rounds of the constraint solver in a step. Each meets the planes anew from the end of the last one. Fewer leave a
/// long slide along a seam to the next tick, with a force that is a tick late; more make the longest tick longer.
inline constexpr int kMaxSolverRounds = 64;

/// Lengths are fractions of the largest coordinate in reach, powers of two, so that nothing depends on the unit.
/// Vertices are floats (2^-24 of the extent), arithmetic is double (2^-52).
///
/// How far the IHIP stays above the surfaces that it passes, or is held by several of: it cannot enter a thinner gap,
/// and misfits of bodies that touch, which are of the order of 2^-24, stay hidden under it.
inline constexpr double kSkin = 0x1p-20;
/// How far above the surface that holds it the path of an IHIP is tested against other bodies: it can be so deep inside
/// of a body that rises from that surface. Smaller shows misfits; larger leaves more of the IHIP inside.
inline constexpr double kPathOffset = 0x1p-23;
/// Of a mesh's extent: a segment that passes beside a triangle by less meets it where another surface may be beside, so that a
/// gap of two rims is closed. Less than the skin, or the IHIP could not go down a wall at its skin; and than the padding of
/// the hierarchy's boxes (kBoxPad).
inline constexpr double kRim = 0x1.cp-21;
/// In skins: how far beyond an edge that bends away the path over it is tested. The planes' skins fill thinner gaps.
inline constexpr double kGap = 2;
/// Cosine between two triangles across such an edge.
inline constexpr double kBend = 0.97;
/// How far above its own triangle a segment starts: far more than the arithmetic's rounding, far less than the
/// vertices'.
inline constexpr double kStartOffset = 0x1p-32;
/// In skins: a plane is held when the IHIP is not farther below it.
inline constexpr double kConstraintTolerance = 0x1p-2;
/// Times the HIP's step: an IHIP that went farther slid from a minimum that ended on the way. Larger lets it begin with
/// a HIP that is too far on already; smaller divides steps over creases.
inline constexpr double kJumpRatio = 4;
/// The same for a step that is not short beside the triangles: a slide over some of them is hardly longer.
inline constexpr double kFastJumpRatio = 0x1.2p0;
/// In skins: a surface that is no farther from the IHIP on its path holds it; to any other the IHIP moves first. Larger
/// cuts corners; smaller takes more rounds in acute grooves.
inline constexpr double kTouchMargin = 16;
/// In skins: a point closer to an edge is on it. The skin hides what is smaller.
inline constexpr double kEdgeTolerance = 0x1p-10;
/// In skins: a triangle that is no farther supports an IHIP that the lifted planes of several hold.
inline constexpr double kSupportMargin = 2;
/// In skins: a triangle that is no farther under the IHIP can be taken up by the neighborhood watch again.
inline constexpr double kRecontactMargin = 4;
/// Rounds of a step that may end no nearer to the HIP: the skin lifts the IHIP where another surface begins to hold it.
inline constexpr int kMaxStalledRounds = 2;
/// In skins: an IHIP that is no deeper inside a body is on its surface. The vertices' rounding hides what is smaller.
inline constexpr double kDepthTolerance = 0x1p-4;
/// A solver round that moves the IHIP by less than this fraction of the penetration ends the step.
inline constexpr double kConvergedRatio = 0x1p-14;

}  // namespace haptics
