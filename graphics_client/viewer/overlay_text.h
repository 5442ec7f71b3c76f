#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/surface/displayed_surface.h"
#include "graphics_client/viewer/palette.h"

// What the overlay says, as plain data: no VTK here.
namespace haptics {

enum class Tone { kPlain, kGood, kWarning, kBad };

struct OverlayLine {
  std::string label;
  std::string value;
  Tone tone = Tone::kPlain;

  bool operator==(const OverlayLine&) const = default;
};

/// What a line of status or contact means, in a sentence, by its label. Empty: nothing is known of it.
[[nodiscard]] std::string overlayTip(const std::string& label);
/// Those that everybody needs, and those that warn.
[[nodiscard]] std::vector<OverlayLine> withoutDetails(std::vector<OverlayLine> lines);

/// What the mouse and the keys do in the window.
[[nodiscard]] const std::vector<OverlayLine>& controlLines();

/// A notice across the top of the picture; empty text: none.
struct Banner {
  std::string text;
  Tone tone = Tone::kPlain;

  bool operator==(const Banner&) const = default;
};

/// A picture that is drawn more seldom is one in which nothing changes (Hz).
inline constexpr double kIdleRate_Hz = 0.75;

/// Telemetry older than this is shown as stale: a few network hiccups, not yet a dead link (s).
inline constexpr double kStaleTelemetry_s = 0.5;

// age_s: of the view's sample now, MirrorView::telemetryAgeAt_s.

/// Whether what is shown is the present: the link is up and telemetry arrives.
[[nodiscard]] bool isCurrent(const MirrorView& view, double age_s);

/// Link, server, servo and scene, always the same number of lines in the same order.
/// @param framesPerSecond  Below kIdleRate_Hz nothing changes.
/// @param coarse  the surface that is drawn farthest from what is felt, if any.
/// @param pitsFeltAsBumps  Of some texture.
[[nodiscard]] std::vector<OverlayLine> statusLines(const MirrorView& view, double age_s, double framesPerSecond,
                                                   const std::optional<CoarseDetail>& coarse = {},
                                                   bool pitsFeltAsBumps = false);

/// Contact and force, always the same number of lines in the same order.
[[nodiscard]] std::vector<OverlayLine> contactLines(const MirrorView& view);

struct LegendRow {
  palette::Shade dot;
  OverlayLine line;
};

/// What the colours of effects mean, of those that the scene has.
[[nodiscard]] std::vector<LegendRow> effectLegend(const MirrorView& view);

/// @param wasLive        the link was live before: "lost" rather than "connecting".
/// @param stateWasReset  the server restarted a moment ago and its scene replaced ours.
[[nodiscard]] Banner bannerFor(const MirrorView& view, double age_s, bool wasLive, bool stateWasReset);

}  // namespace haptics
