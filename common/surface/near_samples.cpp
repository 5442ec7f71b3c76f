#include "common/surface/near_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "common/surface/lattice.h"

namespace haptics {
namespace {

/// Squared distance along one axis from a place within a cube, in sides from its lower face, to the cube so many steps on.
double squaredGap(double within, int steps) {
  if (steps == 0) return 0;
  return steps < 0 ? within * within : (1 - within) * (1 - within);
}

template <class Visit>
void visitNeighbours(Visit visit) {
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) visit(i, j, k);
    }
  }
}

}  // namespace

NearSamples::Place NearSamples::placeOf(Vec3f point) const noexcept {
  const Vec3 at = (Vec3(point) - low_) * perReach_;
  return {static_cast<std::uint64_t>(at.x), static_cast<std::uint64_t>(at.y), static_cast<std::uint64_t>(at.z)};
}

/// In the table, by linear probing.
std::size_t NearSamples::slotOf(std::uint64_t number) const noexcept {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = mixed(number) & mask;
  for (std::size_t step = 0; step < kMaxSteps; ++step, slot = (slot + 1) & mask) {
    if (table_[slot].number == number) return slot;
    if (table_[slot].number == kNone) break;
  }
  return kNoSlot;
}

/// Numbers of the cubes around those that hold samples, each once.
std::vector<std::uint64_t> NearSamples::cubesNear(std::span<const PointSample> samples) const {
  std::vector<std::uint64_t> own, all;
  for (const PointSample& sample : samples) own.push_back(numberOf(placeOf(sample.point)));
  const auto unite = [](std::vector<std::uint64_t>& numbers) {
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  };
  unite(own);
  for (const std::uint64_t number : own) {
    visitNeighbours([&](std::int64_t i, std::int64_t j, std::int64_t k) {
      all.push_back(number + static_cast<std::uint64_t>(i + j * (1 << 21) + k * (std::int64_t{1} << 42)));
    });
  }
  unite(all);
  return all;
}

/// False where one would lie too far from its place.
bool NearSamples::enter(std::span<const std::uint64_t> numbers) {
  const std::size_t mask = table_.size() - 1;
  for (const std::uint64_t number : numbers) {
    std::size_t slot = mixed(number) & mask, step = 0;
    for (; table_[slot].number != kNone; slot = (slot + 1) & mask) {
      if (++step == kMaxSteps) return false;
    }
    table_[slot].number = number;
  }
  return true;
}

/// Samples within reach of the point.
template <class Visit>
void NearSamples::visitCubes(Vec3f point, Visit visit) {
  const Place place = placeOf(point);
  const Vec3 within = (Vec3(point) - low_) * perReach_ - Vec3(place[0], place[1], place[2]);
  visitNeighbours([&](int i, int j, int k) {
    if (squaredGap(within.x, i) + squaredGap(within.y, j) + squaredGap(within.z, k) >= 1) return;
    const auto step = [](std::uint64_t from, int steps) {
      return from + static_cast<std::uint64_t>(std::int64_t{steps});
    };
    visit(table_[slotOf(numberOf({step(place[0], i), step(place[1], j), step(place[2], k)}))]);
  });
}

Result<NearSamples> NearSamples::make(double reach_m, std::span<const PointSample> samples) {
  Vec3 low(samples.front().point), high = low;
  for (const PointSample& sample : samples) {
    low = glm::min(low, Vec3(sample.point));
    high = glm::max(high, Vec3(sample.point));
  }
  NearSamples near;
  near.perReach_ = 1 / reach_m;
  near.low_ = low - 1.5 * reach_m;
  near.cubes_ = glm::floor((high - near.low_) * near.perReach_) + 2.0;
  const double most = std::max({near.cubes_.x, near.cubes_.y, near.cubes_.z});
  if (most > kMaxCubesAlong) {
    return refused("samples", "extend over " + std::to_string(static_cast<std::int64_t>(most)) +
                                  " times the reach; at most " + std::to_string(static_cast<int>(kMaxCubesAlong)) +
                                  " are taken");
  }
  const std::vector<std::uint64_t> numbers = near.cubesNear(samples);
  if (numbers.size() > kMaxCubes) {
    return refused("samples", "lie farther apart than their reach; neighbours are to be within it");
  }
  std::size_t size = std::bit_ceil(numbers.size());
  do {
    size *= 2;
    if (size > 4 * kMaxCubes) return refused("samples", "lie where no table of them is quick; move some of them");
    near.table_.assign(size, Cube{});
  } while (!near.enter(numbers));

  for (const PointSample& sample : samples) near.visitCubes(sample.point, [](Cube& cube) { ++cube.count; });
  std::uint32_t end = 0;
  for (Cube& cube : near.table_) {
    if (cube.count > kMaxNear) {
      return refused("samples", std::to_string(cube.count) +
                                    " of them lie within about their reach of one place; at most " +
                                    std::to_string(kMaxNear) + " may: give a shorter reach");
    }
    cube.first = end;
    end += cube.count;
    cube.count = 0;
  }
  near.lists_.resize(end);
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    near.visitCubes(samples[i].point, [&](Cube& cube) { near.lists_[cube.first + cube.count++] = i; });
  }
  return near;
}

}  // namespace haptics
