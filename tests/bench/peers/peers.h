#pragma once

#include <memory>
#include <span>
#include <string>

#include "common/maths/vec.h"
#include "tests/bench/peers/contest.h"

/// What others offer for the questions of a tick. A peer that is not installed has no contestants.
namespace haptics::bench {

/// A short straight way of the HIP in the mesh's frame, metres.
struct Way {
  Vec3 from;
  Vec3 to;
};

class Embree {
 public:
  explicit Embree(const TriMesh& mesh);
  /// For the program's own description: the version, or what to install.
  [[nodiscard]] static std::string version();

  /// The closest point to each place in turn (answer: distance, m), by a point query whose radius is the distance to
  /// the answer before: the smallest that cannot miss.
  [[nodiscard]] Contestants closest(std::span<const Vec3> places) const;
  /// Does anything lie on the way (answer: 1 or 0)? With and without the flag that makes Embree watertight.
  [[nodiscard]] Contestants occluded(std::span<const Way> ways) const;
  /// The first triangle on the way (answer: the fraction of the way, 1 for none). Both ways again.
  [[nodiscard]] Contestants first(std::span<const Way> ways) const;

 private:
  struct Scenes;
  std::shared_ptr<const Scenes> scenes_;
};

class Cgal {
 public:
  explicit Cgal(const TriMesh& mesh);
  [[nodiscard]] static std::string version();

  /// AABB_tree::closest_point with the answer before as the hint.
  [[nodiscard]] Contestants closest(std::span<const Vec3> places) const;

 private:
  struct Tree;
  std::shared_ptr<const Tree> tree_;
};

}  // namespace haptics::bench
