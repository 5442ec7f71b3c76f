#pragma once

#include <algorithm>
#include <limits>

#include "common/maths/vec.h"

namespace haptics {

/// The smallest axis-aligned box about points.
class Extent {
 public:
  void add(Vec3 place) {
    least_ = glm::min(least_, place);
    most_ = glm::max(most_, place);
  }
  [[nodiscard]] double longest() const {
    const Vec3 size = most_ - least_;
    return std::max({size.x, size.y, size.z});
  }

 private:
  Vec3 least_{std::numeric_limits<double>::infinity()};
  Vec3 most_{-std::numeric_limits<double>::infinity()};
};

}  // namespace haptics
