#pragma once

#include <cstdint>
#include <deque>
#include <memory>

#include "graphics_client/mirror/client_limits.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// Shows what moves and gives, and what touches it, smoothly at any frame rate: at an even pace of the server's time, between
/// the samples that came. The picture lags by as little as has a sample ahead of it. Where nothing moves or gives it is the
/// newest sample. HIP, IHIP, bodies and dents are of the same moment, so that the contact is seen where it is.
class Playback {
 public:
  /// Longest lag behind the freshest sample of the last second (s): what the link takes at best is no lag. Larger is smoother
  /// over a bad link, and later: a person notices that the picture is later than the hand from 15 ms on.
  static constexpr double kMaxLag_s = 0.05;
  /// Between samples that are farther apart than this (s), because others were lost, nothing is made up: the later one is
  /// shown at once. Larger is smoother; a straight way of the IHIP leaves a curved surface by the square of it.
  static constexpr double kLongestGap_s = 0.05;
  /// Scene edits are shown with the first sample that felt them, since a plastic dent that is baked into the shape at rest
  /// ends in that sample, and such a sample not before the edit; but no later than this (s): a servo that sends nothing holds
  /// nothing back.
  static constexpr double kLongestHold_s = 0.25;
  /// For so long a late sample makes the picture lag (s); then it catches up, faster than time by this share.
  static constexpr double kLagMemory_s = 1;
  static constexpr double kCatchUp = 0.05;

  /// The view to draw now. Once a frame; `view` is not null, `now_ns` this host's monotonic clock.
  [[nodiscard]] std::shared_ptr<const MirrorView> at(std::shared_ptr<const MirrorView> view, std::uint64_t now_ns);

 private:
  using View = std::shared_ptr<const MirrorView>;
  std::deque<View> past_;  ///< With a sample each, newest last.
  struct Age {
    std::uint64_t when_ns;
    double age_s;
  };
  std::deque<Age> ages_;  ///< Of the newest sample at each frame of the last kLagMemory_s.
  double lag_s_ = 0;

  /// What the remembered views keep: those that the scene holds no longer too.
  static constexpr std::size_t kMaxAssets_bytes = 2 * kMaxHeldAssets_bytes;

  void remember(const View& view);
  [[nodiscard]] std::size_t keptAssets_bytes() const;
  [[nodiscard]] View inStep(View shown) const;
  void followAge(double age_s, std::uint64_t now_ns);
};

}  // namespace haptics
