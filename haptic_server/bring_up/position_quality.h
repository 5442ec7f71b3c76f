#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// The value below which a share (0 to 1) of them lies; 0 of none.
[[nodiscard]] double percentile(std::vector<double> values, double share);

/// What positions of a device tell of its encoders, whatever the hand does that moves it.
class PositionQuality {
 public:
  explicit PositionQuality(double resolution_m) noexcept : resolution_m_(resolution_m) {}

  /// The next position, and when it was measured.
  void add(Vec3 position, std::uint64_t measured_ns);

  /// Changes of velocity by more than kNoHand_m_per_s from one position to the next.
  [[nodiscard]] int glitches() const noexcept { return glitches_; }
  [[nodiscard]] bool everChanged(int axis) const noexcept { return high_[axis] > low_[axis]; }
  [[nodiscard]] Vec3 range_m() const noexcept { return any_ ? high_ - low_ : Vec3(0); }
  [[nodiscard]] double smallestStep_m(int axis) const { return axes_[index(axis)].smallest_m; }
  /// Positions from one value of an axis to the next at the median, while it moves: a hand that is slow crosses a step of the
  /// encoder now and then, one that is fast several at once. 0: it was not moved enough to tell.
  [[nodiscard]] double positionsPerValue(int axis) const;
  /// Standard deviation of what is added to the axis from one position to the next, where the hand was calmest; 0: positions were too irregular to tell.
  [[nodiscard]] double noise_m(int axis) const noexcept { return axes_[index(axis)].noise_m; }

 private:
  struct Change {
    double moved_m;
    int held;
  };
  struct Axis {
    std::vector<Change> changes;
    double smallest_m = 0;
    int held = 0;
    std::vector<double> bends_m;  ///< Second differences, of a window.
    double noise_m = 0;
    bool judged = false;
  };
  [[nodiscard]] static std::size_t index(int axis) noexcept { return static_cast<std::size_t>(axis); }
  void addValue(Axis& axis, double moved_m);
  void addBend(Axis& axis, double bend_m);

  double resolution_m_;
  std::array<Axis, 3> axes_;
  bool any_ = false;
  Vec3 last_{0}, moved_{0}, velocity_{0}, low_{0}, high_{0};
  std::uint64_t measured_ns_ = 0;
  int regular_ = 0;  ///< Intervals in a row that were.
  int glitches_ = 0;
};

}  // namespace haptics
