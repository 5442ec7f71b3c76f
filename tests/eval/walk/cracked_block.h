#pragma once

#include <array>
#include <vector>

#include "tests/eval/walk/triangle_soup.h"

namespace haptics::eval {

/// A block with a crack of 20 um by 1 um in its top that narrows to a point 14 um down.
struct CrackedBlock {
  static constexpr Vec3 kTip{0.000003, 0, -0.000014};
  TriangleSoup soup;

  CrackedBlock() {
    const float out = 0.1F;
    std::vector<Vec3f> vertices;
    for (const auto& [half, y, z] : {std::array{out, out, 0.0F}, {0.00001F, 0.0000005F, 0.0F}, {out, out, -out}}) {
      for (const Vec3f corner : {Vec3f(-half, -y, z), Vec3f(half, -y, z), Vec3f(half, y, z), Vec3f(-half, y, z)}) {
        vertices.push_back(corner);
      }
    }
    vertices.push_back(Vec3f(kTip));
    std::vector<TriangleIndices> triangles{{8, 10, 9}, {8, 11, 10}};
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t next = (k + 1) % 4;
      triangles.push_back({k, next, 4 + next});
      triangles.push_back({k, 4 + next, 4 + k});
      triangles.push_back({4 + k, 4 + next, 12});
      triangles.push_back({8 + k, 8 + next, next});
      triangles.push_back({8 + k, next, k});
    }
    soup.add(vertices, triangles, Pose{});
    soup.finish();
  }
};

}  // namespace haptics::eval
