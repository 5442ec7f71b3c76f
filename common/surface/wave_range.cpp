#include "common/surface/wave_range.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <queue>
#include <vector>

#include "common/maths/elementary.h"

namespace haptics {
namespace {

constexpr int kMaxDivisor = 12;  ///< Of a combination's factors: k = 5/12 of another is seen to depend on it.
constexpr double kIntegerTolerance = 1e-9;  ///< How far from an integer a factor may be by rounding.
constexpr double kWaveMargin = 0.005;       ///< Of the sum of the amplitudes: the search ends that near to the extreme.
constexpr int kMaxBoxes = 20'000;           ///< And after so many boxes at the latest; the bound holds all the same.

/// amplitude * cos(turns . angles + phase), the angles anywhere.
struct Harmonic {
  double amplitude, phase;
  Vec3 turns;  ///< Whole.
};

/// At most three wave vectors, linearly independent, of which others are rational combinations.
class Base {
 public:
  [[nodiscard]] int size() const noexcept { return size_; }

  /// The vector's factors, divisor * factor whole for a small divisor. Takes the vector into the base where it points out
  /// of it; nothing when it lies in it and is no such combination.
  std::optional<Vec3> factorsOf(Vec3 k) {
    Vec3 factors = glm::inverse(completed()) * k;
    bool within = true;
    for (int i = size_; i < 3; ++i)
      within = within && std::abs(factors[i]) < kIntegerTolerance * glm::length(k) / scale();
    if (!within) {
      vectors_[size_] = k;
      factors = Vec3(0);
      factors[size_++] = 1;
      return factors;
    }
    for (int divisor = 1; divisor <= kMaxDivisor; ++divisor) {
      const Vec3 rounded = glm::round(static_cast<double>(divisor) * factors);
      if (glm::length(static_cast<double>(divisor) * factors - rounded) > divisor * kIntegerTolerance) continue;
      divisor_ = std::lcm(divisor_, divisor);
      return rounded / static_cast<double>(divisor);
    }
    return std::nullopt;
  }
  /// The divisor that makes all factors integers.
  [[nodiscard]] int divisor() const noexcept { return divisor_; }

 private:
  std::array<Vec3, 3> vectors_{};
  int size_ = 0;
  int divisor_ = 1;

  [[nodiscard]] double scale() const { return size_ == 0 ? 1 : glm::length(vectors_[0]); }
  /// With vectors at right angles to it in place of those that are missing.
  [[nodiscard]] glm::dmat3 completed() const {
    if (size_ == 0) return glm::dmat3(1);
    const Vec3 first = vectors_[0];
    const Vec3 aside = std::abs(first.x) < 0.5 * scale() ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 second = size_ > 1 ? vectors_[1] : scale() * glm::normalize(glm::cross(first, aside));
    const Vec3 third = size_ > 2 ? vectors_[2] : scale() * glm::normalize(glm::cross(first, second));
    return {first, second, third};
  }
};

/// A cube of angles, and what the sum cannot exceed in it.
struct Box {
  Vec3 middle;
  double half;
  double atMost;
  bool operator<(const Box& other) const noexcept { return atMost < other.atMost; }
};

/// Branch and bound for the highest value of a sum of harmonics.
class Ascent {
 public:
  Ascent(std::span<const Harmonic> harmonics, int dimensions) : harmonics_(harmonics), dimensions_(dimensions) {
    for (const Harmonic& h : harmonics_) {
      const double turns = std::abs(h.turns.x) + std::abs(h.turns.y) + std::abs(h.turns.z);
      sum_ += std::abs(h.amplitude);
      bend_ += std::abs(h.amplitude) * turns * turns;
    }
  }

  [[nodiscard]] double highest() {
    std::priority_queue<Box> open;
    open.push(bounded(Vec3(std::numbers::pi), std::numbers::pi));
    for (int boxes = 1; open.top().atMost - found_ > kWaveMargin * sum_ && boxes < kMaxBoxes;
         boxes += 1 << dimensions_) {
      const Box box = open.top();
      open.pop();
      for (int part = 0; part < 1 << dimensions_; ++part) {
        Vec3 middle = box.middle;
        for (int d = 0; d < dimensions_; ++d) middle[d] += (part >> d & 1 ? 0.5 : -0.5) * box.half;
        open.push(bounded(middle, box.half / 2));
      }
    }
    return open.top().atMost;
  }

 private:
  std::span<const Harmonic> harmonics_;
  int dimensions_;
  double sum_ = 0;
  double bend_ = 0;  // bound of the second derivative when all angles change by as much
  double found_ = -std::numeric_limits<double>::infinity();

  Box bounded(Vec3 middle, double half) {
    double value = 0;
    Vec3 slope(0);
    for (const Harmonic& h : harmonics_) {
      const auto [sine, cosine] = elementary::sineCosine(glm::dot(h.turns, middle) + h.phase);
      value += h.amplitude * cosine;
      slope -= h.amplitude * sine * h.turns;
    }
    found_ = std::max(found_, value);
    const double rise = (std::abs(slope.x) + std::abs(slope.y) + std::abs(slope.z)) * half + 0.5 * bend_ * half * half;
    return {middle, half, std::min(value + rise, sum_)};
  }
};

}  // namespace

Range rangeOf(std::span<const PlaneWave> waves) {
  Base base;
  double independent = 0;
  struct Combination {
    const PlaneWave* wave;
    Vec3 factors;
  };
  std::vector<Combination> combinations;
  for (const PlaneWave& wave : waves) {
    if (const auto factors = base.factorsOf(wave.k)) {
      combinations.push_back({&wave, *factors});
    } else {
      independent += std::abs(wave.amplitude);
    }
  }

  std::vector<Harmonic> harmonics;
  for (const auto& [wave, factors] : combinations) {
    const Vec3 turns = glm::round(static_cast<double>(base.divisor()) * factors);
    harmonics.push_back({wave->amplitude, wave->phase_rad, turns});
  }
  const double highest = Ascent(harmonics, base.size()).highest();
  for (Harmonic& h : harmonics) h.amplitude = -h.amplitude;
  const double lowest = -Ascent(harmonics, base.size()).highest();
  return {lowest - independent, highest + independent};
}

}  // namespace haptics
