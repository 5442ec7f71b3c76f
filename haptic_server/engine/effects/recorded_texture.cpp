#include "haptic_server/engine/effects/recorded_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "common/maths/elementary.h"

namespace haptics {
namespace {

/// The ladder goes on at this rate at most: a hand feels nothing above half of it. Higher needs a longer ladder for the same detail.
constexpr double kLadder_Hz = 2000;
/// In which the velocity follows to 1 - 1/e. Longer feels late; shorter lets steps of the encoder through.
constexpr double kSmoothing_s = 0.01;
/// Of what remembers less. Fewer follow no broad peaks that are bent by the conversion.
constexpr double kFewestRungs = 32;
/// Frequencies by which densities are added up. Fewer miss narrow peaks.
constexpr std::size_t kFrequencies = 4096;
/// Of the mean density: what is below would make the ladder ill-conditioned. Larger hides what models of many coefficients have
/// between their peaks.
constexpr double kFloor = 1e-10;

/// A(z) = 1 + a_1 / z + ..., of these reflection coefficients.
[[nodiscard]] std::vector<double> polynomialOf(std::span<const double> reflection) {
  std::vector<double> a{1};
  for (const double k : reflection) {
    a.push_back(0);
    std::vector<double> next = a;
    for (std::size_t i = 1; i < a.size(); ++i) next[i] += k * a[a.size() - 1 - i];
    a = std::move(next);
  }
  return a;
}

[[nodiscard]] double squaredAt(const std::vector<double>& a, elementary::SineCosine turn) noexcept {
  double real = 0, imaginary = 0;
  for (auto i = a.rbegin(); i != a.rend(); ++i) {
    const double next = real * turn.cosine + imaginary * turn.sine + *i;
    imaginary = imaginary * turn.cosine - real * turn.sine;
    real = next;
  }
  return real * real + imaginary * imaginary;
}

/// Levinson & Durbin: the ladder whose output has this autocorrelation, of a variance of 1 at lag 0 of the same.
[[nodiscard]] RecordedTexture::Reflection ladderOf(const std::array<double, kLadderOrder + 1>& correlation) noexcept {
  RecordedTexture::Reflection reflection{};
  std::array<double, kLadderOrder + 1> a{1}, next{};
  double left = correlation[0];
  for (std::size_t m = 1; m <= kLadderOrder; ++m) {
    double sum = 0;
    for (std::size_t i = 0; i < m; ++i) sum += a[i] * correlation[m - i];
    const double k = -sum / left;
    if (!(std::abs(k) < 1)) break;  // what is left is of rounding alone
    reflection[m - 1] = k;
    next = a;
    for (std::size_t i = 1; i <= m; ++i) next[i] += k * a[m - i];
    a = next;
    left *= 1 - k * k;
  }
  return reflection;
}

/// What is the same for all models: where the ladder's frequencies are in the recording.
class Conversion {
 public:
  Conversion(double recorded_Hz, double ladder_Hz, std::uint64_t every)
      : isSame_(every == 1 && std::abs(ladder_Hz / recorded_Hz - 1) < kSameRate) {
    const double highest_Hz = ladder_Hz / 2, bent_Hz = 0.8 * highest_Hz, recordedHighest_Hz = recorded_Hz / 2;
    for (std::size_t j = 0; j < kFrequencies; ++j) {
      const double part = (static_cast<double>(j) + 0.5) / kFrequencies, own_Hz = part * highest_Hz;
      // Near the highest it comes to a stand, so that the density has no corner there, which no ladder could follow.
      const double beyond_Hz = std::max(0.0, own_Hz - bent_Hz);
      const double at_Hz = own_Hz - beyond_Hz * beyond_Hz / (2 * (highest_Hz - bent_Hz));
      own_[j] = elementary::cos(std::numbers::pi * part);
      recorded_[j] = elementary::sineCosine(2 * std::numbers::pi * std::min(at_Hz / recorded_Hz, 0.5));
      // Beyond what was recorded it falls by 24 dB an octave.
      const double ratio = std::min(1.0, recordedHighest_Hz / at_Hz), fall = ratio * ratio * ratio * ratio;
      scale_[j] = 2 * highest_Hz / (kFrequencies * recorded_Hz) * fall / between(own_Hz / ladder_Hz, every);
    }
  }

  [[nodiscard]] RecordedTexture::Model operator()(std::span<const double> recorded) const {
    if (isSame_) {
      RecordedTexture::Model model{recorded[0], {}};
      std::ranges::copy(recorded.subspan(1), model.reflection.begin());
      return model;
    }
    const std::vector<double> a = polynomialOf(recorded.subspan(1));
    double white = 1, mean = 0;
    for (const double k : recorded.subspan(1)) white *= 1 - k * k;
    std::vector<double> density(kFrequencies);
    for (std::size_t j = 0; j < kFrequencies; ++j) {
      density[j] = std::min(white / squaredAt(a, recorded_[j]) * scale_[j], 1.0);  // one peak has all of it at most
      mean += density[j] / kFrequencies;
    }
    std::array<double, kLadderOrder + 1> correlation{};
    for (std::size_t j = 0; j < kFrequencies; ++j) {
      double before = own_[j], now = 1;
      for (double& sum : correlation) {
        sum += (density[j] + kFloor * mean) * now;
        const double next = 2 * own_[j] * now - before;
        before = now;
        now = next;
      }
    }
    return {recorded[0] * std::sqrt(correlation[0]), ladderOf(correlation)};
  }

 private:
  /// Power that is left at this part of the ladder's rate of what goes straight from one output to the next.
  [[nodiscard]] static double between(double part, std::uint64_t every) noexcept {
    if (every == 1) return 1;
    const double count = static_cast<double>(every);
    const double mean =
        elementary::sin(std::numbers::pi * part) / (count * elementary::sin(std::numbers::pi * part / count));
    return mean * mean * mean * mean;
  }

  static constexpr double kSameRate = 1e-9;  ///< What rounding makes of a period.

  bool isSame_;
  std::array<double, kFrequencies> own_, scale_;
  std::array<elementary::SineCosine, kFrequencies> recorded_;
};

/// Its neighbours among ascending values, and how far it is from the first to the second.
struct Place {
  std::size_t first = 0, second = 0;
  double part = 0;
  double share = 1;  ///< Below the lowest less, 0 at 0.
};

[[nodiscard]] Place placeIn(const std::vector<double>& values, double value) noexcept {
  if (value <= values.front()) return {0, 0, 0, std::max(0.0, value / values.front())};
  std::size_t second = 1;
  while (second < values.size() && values[second] < value) ++second;
  if (second == values.size()) return {second - 1, second - 1, 0, 1};
  return {second - 1, second, (value - values[second - 1]) / (values[second] - values[second - 1]), 1};
}

/// Even between -sqrt(3) and sqrt(3), of which the variance is 1: the mixer of SplitMix64 (Steele, Lea & Flood 2014).
[[nodiscard]] double noise(std::uint64_t number) noexcept {
  std::uint64_t z = (number + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  z ^= z >> 31;
  return std::numbers::sqrt3 * (static_cast<double>(z >> 11) * 0x1p-52 - 1);
}

}  // namespace

RecordedTexture::RecordedTexture(const Effect& effect, double period_s)
    : speeds_m_per_s_(effect.speeds_m_per_s),
      forces_N_(effect.forces_N),
      amplitude_N_(effect.amplitude_N),
      smoothing_(std::min(1.0, period_s / kSmoothing_s)),
      every_(static_cast<std::uint64_t>(std::ceil(0.999999 / (kLadder_Hz * period_s)))) {
  const double ladder_Hz = 1 / (period_s * static_cast<double>(every_));
  const Conversion convert(effect.sample_rate_Hz, ladder_Hz, every_);
  const std::size_t count = speeds_m_per_s_.size() * forces_N_.size(), size = effect.models.size() / count;
  // Twice the time over which a model looks back: it takes that much of a ladder at another rate.
  const double longest = 2 * static_cast<double>(size - 1) * ladder_Hz / effect.sample_rate_Hz;
  rungs_ = static_cast<std::size_t>(std::clamp(std::ceil(longest), kFewestRungs, double{kLadderOrder}));
  for (std::size_t i = 0; i < count; ++i) models_.push_back(convert(std::span(effect.models).subspan(i * size, size)));
}

RecordedTexture::Model RecordedTexture::at(double speed_m_per_s, double normal_N) const noexcept {
  const Place speed = placeIn(speeds_m_per_s_, speed_m_per_s), force = placeIn(forces_N_, normal_N);
  Model between;
  const auto add = [&](std::size_t i, std::size_t j, double part) {
    if (part == 0) return;
    const Model& model = models_[i * forces_N_.size() + j];
    between.deviation += part * model.deviation;
    for (std::size_t m = 0; m < rungs_; ++m) between.reflection[m] += part * model.reflection[m];
  };
  add(speed.first, force.first, (1 - speed.part) * (1 - force.part));
  add(speed.first, force.second, (1 - speed.part) * force.part);
  add(speed.second, force.first, speed.part * (1 - force.part));
  add(speed.second, force.second, speed.part * force.part);
  between.deviation *= speed.share * force.share;
  return between;
}

/// The normalised ladder (Gray & Markel 1975): each rung turns two numbers and makes neither longer, whatever the coefficients of this
/// step are.
double RecordedTexture::step(TextureMemory& memory, std::span<const double> reflection) noexcept {
  double forward = noise(memory.drawn++);
  for (std::size_t m = reflection.size(); m > 0; --m) {
    const double k = reflection[m - 1], c = std::sqrt(std::max(0.0, 1 - k * k)), backward = memory.backward[m - 1];
    if (m < reflection.size()) memory.backward[m] = k * forward + c * backward;
    forward = c * forward - k * backward;
  }
  memory.backward[0] = forward;
  return forward;
}

RecordedTexture::Felt RecordedTexture::felt(TextureMemory& memory, const Vec3& normal, double normal_N,
                                            const Vec3& velocity) const noexcept {
  memory.velocity += smoothing_ * (velocity - memory.velocity);
  memory.velocity -= glm::dot(memory.velocity, normal) * normal;
  const double speed_m_per_s = glm::length(memory.velocity);
  const Model model = at(speed_m_per_s, normal_N);
  if (++memory.passed >= every_) {
    memory.passed = 0;
    memory.last = memory.next;
    memory.next = step(memory, std::span(model.reflection).first(rungs_));
  }
  if (speed_m_per_s == 0) return {};
  const double strength_N = amplitude_N_ * model.deviation,
               change = (memory.next - memory.last) / static_cast<double>(every_);
  const double output = memory.last + static_cast<double>(memory.passed + 1) * change;
  return {strength_N * output / speed_m_per_s * glm::cross(normal, memory.velocity), strength_N * std::abs(change)};
}

}  // namespace haptics
