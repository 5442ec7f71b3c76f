#include "common/surface/point_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/surface/fade.h"
#include "common/surface/sampled_field.h"

namespace haptics {
namespace {

constexpr std::size_t kLookedAt = 4096;  ///< Samples whose surroundings give slope and curvature.
constexpr std::size_t kStarts = 1000;    ///< Most extreme samples that are looked about for an extreme value,
constexpr std::size_t kClimbs = 64;      ///< and the best places about them, from which it is climbed to.
constexpr double kMargin = 1.1;          ///< Of what is found by sampling.
constexpr double kPointMargin = 0.005;   ///< Of the values' range: how far a bound lies outside what was found.
constexpr double kReachStep = 1e-4;      ///< Of the reach.

bool isCanonical(float x, float most) {
  const bool negativeZero = x == 0 && std::signbit(x);
  return std::abs(x) <= most && !negativeZero;  // false of what is no number
}

Result<void> check(float reach_m, std::span<const PointSample> samples) {
  if (!(reach_m >= PointField::kMinReach_m && reach_m <= PointField::kMaxReach_m)) {
    return refused("reach_m", "is " + std::to_string(reach_m) + "; give 1e-6 to 1000 m");
  }
  if (samples.empty() || samples.size() > PointField::kMaxSamples) {
    return refused("count",
                   "is " + std::to_string(samples.size()) + "; give 1 to " + std::to_string(PointField::kMaxSamples));
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::string name = "samples[" + std::to_string(i) + "].";
    for (int axis = 0; axis < 3; ++axis) {
      if (isCanonical(samples[i].point[axis], PointField::kMaxCoordinate_m)) continue;
      return refused(name + "point",
                     "is no point within " + std::to_string(static_cast<int>(PointField::kMaxCoordinate_m)) + " m");
    }
    if (isCanonical(samples[i].value, kMaxFieldValue)) continue;
    return refused(name + "value", "is " + std::to_string(samples[i].value) + "; give a finite number within " +
                                       std::to_string(static_cast<int>(kMaxFieldValue)) + ", and 0 without a sign");
  }
  return {};
}

/// The largest stretch of a symmetric matrix, by power iteration of its square.
double normOf(const glm::dmat3& matrix) {
  constexpr int kRounds = 12;
  Vec3 v(0.48, 0.6, 0.64);
  double norm = 0;
  for (int i = 0; i < kRounds; ++i) {
    v = matrix * v;
    norm = glm::length(v);
    if (!(norm > 0)) return 0;
    v /= norm;
  }
  return norm;
}

/// Looks for the highest value of a field, or of what it is upside down.
class Summit {
 public:
  Summit(const PointField& field, double sign) : field_(field), sign_(sign) {}

  [[nodiscard]] double find() const {
    std::vector<Place> places;
    for (const PointSample& sample : field_.samples()) places.push_back(at(Vec3(sample.point)));
    keepBest(places, kStarts);
    // Off the surface fewer samples have a part in a value, which may then be higher.
    for (std::size_t i = 0, count = places.size(); i < count; ++i) {
      for (int corner = 0; corner < 27; ++corner) {
        const Vec3 aside(corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1);
        places.push_back(at(places[i].point + 0.35 * field_.reach_m() * aside));
      }
    }
    keepBest(places, kClimbs);
    double highest = places.front().height;
    for (const Place& place : places) highest = std::max(highest, climbFrom(place));
    return highest;
  }

 private:
  struct Place {
    Vec3 point;
    double height;
  };

  const PointField& field_;
  double sign_;

  [[nodiscard]] Place at(Vec3 point) const {
    interruptionPoint();
    return {point, sign_ * field_.at(point).value};
  }
  static void keepBest(std::vector<Place>& places, std::size_t most) {
    const auto end = places.begin() + static_cast<std::ptrdiff_t>(std::min(most, places.size()));
    std::partial_sort(places.begin(), end, places.end(),
                      [](const Place& a, const Place& b) { return a.height > b.height; });
    places.erase(end, places.end());
  }
  [[nodiscard]] double climbFrom(Place place) const {
    for (double step_m = 0.1 * field_.reach_m(); step_m > 1e-3 * field_.reach_m();) {
      const Vec3 gradient = sign_ * field_.at(place.point).gradient;
      const double slope = glm::length(gradient);
      if (!(slope > 0)) break;
      const Place next = at(place.point + step_m / slope * gradient);
      if (next.height > place.height) {
        place = next;
      } else {
        step_m /= 2;
      }
    }
    return place.height;
  }
};

/// Where at most so many samples are, and half way to the nearest of the others.
template <class Visit>
void visitSurface(const PointField& field, const NearSamples& near, Visit visit) {
  const auto samples = field.samples();
  const std::size_t stride = (samples.size() + kLookedAt - 1) / kLookedAt;
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    interruptionPoint();
    const Vec3 here(samples[i].point);
    visit(here);
    double least = field.reach_m();
    Vec3 nearest = here;
    for (const std::uint32_t j : near.lookUp(here)) {
      const double distance = glm::distance(here, Vec3(samples[j].point));
      if (j == i || distance >= least) continue;
      least = distance;
      nearest = Vec3(samples[j].point);
    }
    visit(0.5 * (here + nearest));
  }
}

FieldBounds boundsOf(const PointField& field, const NearSamples& near) {
  FieldBounds bounds;
  const double step_m = kReachStep * field.reach_m();
  visitSurface(field, near, [&](Vec3 place) {
    bounds.slope_per_m = std::max(bounds.slope_per_m, glm::length(field.at(place).gradient));
    glm::dmat3 second;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 aside(0);
      aside[axis] = step_m;
      second[axis] = (field.at(place + aside).gradient - field.at(place - aside).gradient) / (2 * step_m);
    }
    bounds.curvature_per_m2 = std::max(bounds.curvature_per_m2, normOf(second));
  });
  bounds.slope_per_m *= kMargin;
  bounds.curvature_per_m2 *= kMargin;

  const auto [least, most] = std::ranges::minmax(field.samples(), {}, &PointSample::value);
  const double range = static_cast<double>(most.value) - least.value;
  // An average lies between the samples, and fades to 0.
  bounds.lowest = std::max(-Summit(field, -1).find() - kPointMargin * range, std::min<double>(least.value, 0));
  bounds.highest = std::min(Summit(field, 1).find() + kPointMargin * range, std::max<double>(most.value, 0));
  bounds.lowest = std::min(bounds.lowest, 0.0);
  bounds.highest = std::max(bounds.highest, 0.0);
  return bounds;
}

}  // namespace

PointField::PointField(float reach_m, std::vector<PointSample> samples, NearSamples near)
    : reach_m_(reach_m),
      perSquaredReach_(1 / (static_cast<double>(reach_m) * reach_m)),
      samples_(std::move(samples)),
      near_(std::move(near)),
      bounds_(boundsOf(*this, near_)) {}

Result<PointField> PointField::make(float reach_m, std::vector<PointSample> samples) {
  if (auto right = check(reach_m, samples); !right) return tl::unexpected<Error>(std::move(right).error());
  auto near = NearSamples::make(reach_m, samples);
  if (!near) return tl::unexpected<Error>(std::move(near).error());
  return PointField(reach_m, std::move(samples), *std::move(near));
}

FieldSample PointField::at(Vec3 point) const noexcept {
  struct Within {
    double inside;  // 1 - (d / reach)^2
    std::uint32_t sample;
  };
  std::array<Within, NearSamples::kMaxNear> within;
  std::size_t count = 0;
  for (const std::uint32_t i : near_.lookUp(point)) {  // without branches: a third of them are within reach
    const double inside = 1 - squaredLength(point - Vec3(samples_[i].point)) * perSquaredReach_;
    within[count] = {inside, i};
    count += inside > 0 ? 1 : 0;
  }

  double weights = 0, moment = 0;
  Vec3 slopes(0), slopeMoments(0);  // of both, over -6 / reach^2
  for (std::size_t i = 0; i < count; ++i) {
    const auto [inside, number] = within[i];
    const PointSample& sample = samples_[number];
    const double value = sample.value, squared = inside * inside, weight = squared * inside;
    const Vec3 slope = squared * (point - Vec3(sample.point));
    weights += weight;
    moment += weight * value;
    slopes += slope;
    slopeMoments += value * slope;
  }
  if (!(weights > 0)) return {};
  const double mean = moment / weights;
  const Vec3 slope = -6 * perSquaredReach_ / weights * (slopeMoments - mean * slopes);
  if (weights >= kWholeWeight) return {mean, slope};
  const Ramp present = fade(weights / kWholeWeight);
  return {present.value * mean,
          present.value * slope - 6 * perSquaredReach_ * mean * present.slope / kWholeWeight * slopes};
}

}  // namespace haptics
