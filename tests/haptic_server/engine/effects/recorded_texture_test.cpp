// Recorded textures: the spectrum of what is felt against that of the poles, poles between models, what noise makes of them.
#include "haptic_server/engine/effects/recorded_texture.h"

#include <gtest/gtest.h>

#include <complex>

#include "haptic_server/engine/effects/effect_field.h"
#include "tests/haptic_server/engine/effects/effect_laws.h"

namespace haptics::recorded_texture_test {
namespace {

using effect_laws::Random;
using Complex = std::complex<double>;
constexpr double kPi = std::numbers::pi;
constexpr Vec3 kUp(0, 0, 1);

using Fine = long double;
/// 1 + a_1 / z + ... with these zeros.
std::vector<Fine> polynomialOf(const std::vector<Complex>& poles) {
  std::vector<std::complex<Fine>> a{1};
  for (const Complex pole : poles) {
    a.push_back(0);
    for (std::size_t i = a.size() - 1; i > 0; --i) a[i] -= std::complex<Fine>(pole) * a[i - 1];
  }
  std::vector<Fine> real;
  for (const std::complex<Fine> one : a) real.push_back(one.real());
  return real;
}

std::vector<Fine> polynomialOf(const RecordedTexture::Reflection& reflection) {
  std::vector<Fine> a{1};
  for (const double k : reflection) {
    std::vector<Fine> next(a);
    next.push_back(0);
    for (std::size_t i = 0; i < a.size(); ++i) next[a.size() - i] += Fine{k} * a[i];
    a = next;
  }
  return a;
}

std::complex<Fine> valueAt(const std::vector<Fine>& a, Fine angle_rad) {
  const std::complex<Fine> z = std::polar(Fine{1}, angle_rad);
  std::complex<Fine> value = 0;
  for (const Fine one : a) value = value * z + one;
  return value;
}

/// By how much the argument of z^p A(z) turns from one place of the unit circle to another: halved until a part is small.
Fine turnOf(const std::vector<Fine>& a, Fine from, Fine to, std::complex<Fine> first, std::complex<Fine> last) {
  const Fine turn = std::arg(last / first);
  if (to - from < 1e-15L || (std::abs(turn) < 0.5L && to - from < 0.01L)) return turn;
  const Fine middle = (from + to) / 2;
  const std::complex<Fine> value = valueAt(a, middle);
  return turnOf(a, from, middle, first, value) + turnOf(a, middle, to, value, last);
}

/// From the highest coefficient down (Schur & Cohn).
std::vector<double> reflectionOf(std::vector<Fine> a) {
  std::vector<double> reflection;
  while (a.size() > 1) {
    const Fine k = a.back();
    reflection.insert(reflection.begin(), static_cast<double>(k));
    std::vector<Fine> lower(a.size() - 1);
    for (std::size_t i = 0; i < lower.size(); ++i) lower[i] = (a[i] - k * a[a.size() - 1 - i]) / (1 - k * k);
    a = lower;
  }
  return reflection;
}

/// One pair of poles in each part of the frequencies.
std::vector<Complex> randomPoles(int pairs, double rate_Hz, Random& random) {
  std::vector<Complex> poles;
  for (int i = 0; i < pairs; ++i) {
    const double at_Hz = (i + random.number(0.1, 0.9)) * rate_Hz / 2 / pairs;
    const double wide_Hz = std::max(40.0, at_Hz) * random.number(0.3, 1);
    const Complex pole = std::exp(Complex(-kPi * wide_Hz, 2 * kPi * at_Hz) / rate_Hz);
    poles.insert(poles.end(), {pole, std::conj(pole)});
  }
  return poles;
}

/// Of a process of variance 1, a Hz, over positive frequencies.
class Density {
 public:
  Density(const std::vector<Complex>& poles, double rate_Hz) : poles_(poles), rate_Hz_(rate_Hz) {
    constexpr int kParts = 20'000;
    double sum = 0;
    for (int i = 0; i < kParts; ++i) sum += shape((i + 0.5) * rate_Hz / 2 / kParts);
    scale_ = kParts / (sum * rate_Hz / 2);
  }
  double at(double frequency_Hz) const { return scale_ * shape(frequency_Hz); }

 private:
  double shape(double frequency_Hz) const {
    const Complex back = std::exp(Complex(0, -2 * kPi * frequency_Hz / rate_Hz_));
    Complex product = 1;
    for (const Complex pole : poles_) product *= 1.0 - pole * back;
    return 1 / std::norm(product);
  }

  std::vector<Complex> poles_;
  double rate_Hz_, scale_;
};

Effect textureOf(std::vector<double> reflection, double rate_Hz) {
  Effect effect{.kind = Effect::Kind::kRecordedTexture, .amplitude_N = 1, .sample_rate_Hz = rate_Hz};
  effect.speeds_m_per_s = {0.1};
  effect.forces_N = {1};
  effect.models = {1};
  effect.models.insert(effect.models.end(), reflection.begin(), reflection.end());
  return effect;
}

/// Of what is felt across a steady stroke, a Hz (Welch): the mean over parts of 0.25 s, each under a Hann window.
std::vector<double> feltDensity(const RecordedTexture& texture, double rate_Hz,
                                const std::vector<double>& frequencies_Hz) {
  constexpr int kParts = 3000;
  const int size = static_cast<int>(rate_Hz / 4);
  TextureMemory memory;
  const auto step = [&] { return texture.felt(memory, kUp, 1, Vec3(0.1, 0, 0)).force_N.y; };
  for (int i = 0; i < size; ++i) static_cast<void>(step());
  std::vector<double> window, sums(frequencies_Hz.size(), 0.0), part(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) window.push_back(0.5 - 0.5 * std::cos(2 * kPi * (i + 0.5) / size));
  for (int n = 0; n < kParts; ++n) {
    for (int i = 0; i < size; ++i) part[static_cast<std::size_t>(i)] = window[static_cast<std::size_t>(i)] * step();
    for (std::size_t j = 0; j < sums.size(); ++j) {  // Goertzel
      const double twice = 2 * std::cos(2 * kPi * frequencies_Hz[j] / rate_Hz);
      double now = 0, before = 0;
      for (const double value : part) before = std::exchange(now, value + twice * now - before);
      sums[j] += now * now + before * before - twice * now * before;
    }
  }
  double square = 0;
  for (const double value : window) square += value * value;
  for (double& sum : sums) sum *= 2 / (square * rate_Hz * kParts);
  return sums;
}

TEST(RecordedTexture, SoundsAsItsModelFrom20To400Hz) {
  std::vector<double> frequencies_Hz;
  for (double f = 20; f <= 400; f += 20) frequencies_Hz.push_back(f);
  Random random(1);
  double worst_dB = 0;
  for (const double rate_Hz : {1000.0, 4000.0}) {
    for (const double recorded_Hz : {1000.0, 2000.0, 10'000.0}) {
      for (int i = 0; i < 2; ++i) {
        const auto poles = randomPoles(recorded_Hz > 5000   ? 9
                                       : recorded_Hz > 1000 ? 5
                                                            : 4 + 4 * i,
                                       recorded_Hz, random);
        const Effect effect = textureOf(reflectionOf(polynomialOf(poles)), recorded_Hz);
        const auto felt = feltDensity(RecordedTexture(effect, 1 / rate_Hz), rate_Hz, frequencies_Hz);
        const Density asked(poles, recorded_Hz);
        for (std::size_t j = 0; j < felt.size(); ++j) {
          const double off_dB = 10 * std::log10(felt[j] / asked.at(frequencies_Hz[j]));
          worst_dB = std::max(worst_dB, std::abs(off_dB));
          EXPECT_LT(std::abs(off_dB), 0.5) << frequencies_Hz[j] << " Hz of " << recorded_Hz << " at " << rate_Hz;
        }
      }
    }
  }
  RecordProperty("worst_dB", std::to_string(worst_dB));
}

/// Of what is felt, by the ladder's own coefficients, a Hz.
/// @param every  Ticks from one output to the next, between which straight lines go.
double ladderDensity(const RecordedTexture::Model& model, double ladder_Hz, double every, double frequency_Hz) {
  Fine white = 2 * Fine{model.deviation} * Fine{model.deviation} / Fine{ladder_Hz};
  for (const double k : model.reflection) white *= 1 - Fine{k} * Fine{k};
  const double angle_rad = 2 * kPi * frequency_Hz / ladder_Hz;
  const double left = every > 1 ? std::sin(angle_rad / 2) / (every * std::sin(angle_rad / 2 / every)) : 1;
  return static_cast<double>(white / std::norm(valueAt(polynomialOf(model.reflection), Fine{angle_rad}))) *
         std::pow(left, 4);
}

/// Without the scatter that noise has, so that models of all orders, at all rates, take no longer.
TEST(RecordedTexture, ModelsOfEveryOrderKeepTheirSpectrumAtEveryRate) {
  Random random(6);
  double worst_dB = 0;
  for (const double rate_Hz : {1000.0, 1500.0, 2500.0, 3900.0, 4000.0, 10'000.0}) {
    const double every = std::ceil(rate_Hz / 2000);
    for (const double recorded_Hz : {1000.0, 1500.0, 2000.0, 3000.0, 10'000.0}) {
      for (const int pairs : {1, 8, 12, 16}) {
        for (int i = 0; i < 5; ++i) {
          const auto poles = randomPoles(pairs, recorded_Hz, random);
          const RecordedTexture texture(textureOf(reflectionOf(polynomialOf(poles)), recorded_Hz), 1 / rate_Hz);
          const RecordedTexture::Model model = texture.at(0.1, 1);
          const Density asked(poles, recorded_Hz);
          for (double f = 20; f <= 400; f += 10) {
            const double off_dB = 10 * std::log10(ladderDensity(model, rate_Hz / every, every, f) / asked.at(f));
            worst_dB = std::max(worst_dB, std::abs(off_dB));
            ASSERT_LT(std::abs(off_dB), 1) << f << " Hz, " << 2 * pairs << " coefficients at " << recorded_Hz
                                           << " Hz, servo at " << rate_Hz << " Hz";
          }
        }
      }
    }
  }
  RecordProperty("worst_dB", std::to_string(worst_dB));
}

/// The servo's rate is 1 kHz, no model is of much less than two numbers; all reflection coefficients as near to 1 as one may ask for.
Effect randomGrid(Random& random) {
  Effect effect = textureOf({}, random.chance() ? 1000 : 10'000);
  effect.speeds_m_per_s = {0.01, 0.05, 0.2};
  effect.forces_N = {0.5, 3};
  effect.models.clear();
  const int order = 1 + static_cast<int>(random.number(0, 31.9));
  const double most = random.chance() ? 0.99999 : 0.8;
  for (int model = 0; model < 6; ++model) {
    effect.models.push_back(random.number(0, 1));
    for (int i = 0; i < order; ++i)
      effect.models.push_back(most < 0.9 && random.chance() ? 0 : random.number(-most, most));
  }
  return effect;
}

/// By the argument of A round the unit circle: as many zeros as it has are within.
TEST(RecordedTexture, EveryModelBetweenTwoIsStable) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const RecordedTexture texture(randomGrid(random), random.chance() ? 1e-3 : 5e-5);
    for (int j = 0; j < 10; ++j) {
      const RecordedTexture::Model model = texture.at(random.number(0, 0.3), random.number(0, 4));
      ASSERT_TRUE(std::isfinite(model.deviation)) << i;
      const std::vector<Fine> a = polynomialOf(model.reflection);
      const Fine round = 2 * std::numbers::pi_v<Fine>;
      const Fine turned = turnOf(a, 0, round, valueAt(a, 0), valueAt(a, round));
      ASSERT_NEAR(static_cast<double>(turned / round), static_cast<double>(a.size() - 1), 0.01) << i;
    }
  }
}

/// Whatever becomes of the model from step to step: the ladder's residuals stay white.
TEST(RecordedTexture, IsNoLouderWhileItsModelChanges) {
  Random random(3);
  std::vector<RecordedTexture> textures;
  for (int i = 0; i < 20; ++i) textures.emplace_back(randomGrid(random), 1e-3);
  TextureMemory memory;
  double square = 0, held = 0;
  constexpr int kSteps = 1'000'000;
  for (int i = 0; i < kSteps; ++i) {
    const auto& texture = textures[static_cast<std::size_t>(random.number(0, 19.99))];
    const double output =
        RecordedTexture::step(memory, texture.at(random.number(0, 0.3), random.number(0, 4)).reflection);
    square += output * output;
    double now = 0;
    for (const double one : memory.backward) now += one * one;
    ASSERT_LE(now, held + 3 + 1e-9) << "a step brings no more than its noise, step " << i;
    held = now;
  }
  EXPECT_NEAR(square / kSteps, 1, 0.02);
}

TEST(RecordedTexture, IsSilentAtRestAndWithoutForce) {
  Random random(4);
  const RecordedTexture texture(randomGrid(random), 1e-3);
  TextureMemory memory;
  for (int i = 0; i < 500; ++i) static_cast<void>(texture.felt(memory, kUp, 1, Vec3(0.05, 0.02, 0.3)));
  const RecordedTexture::Felt stroked = texture.felt(memory, kUp, 1, Vec3(0.05, 0.02, 0.3));
  EXPECT_GT(glm::length(stroked.force_N), 1e-3);
  EXPECT_NEAR(stroked.force_N.z, 0, 1e-12) << "along the surface,";
  EXPECT_NEAR(glm::dot(stroked.force_N, Vec3(0.05, 0.02, 0)), 0, 1e-12) << "and across the stroke";
  EXPECT_EQ(texture.felt(memory, kUp, 0, Vec3(0.05, 0, 0)).force_N, Vec3(0));
  for (int i = 0; i < 500; ++i) static_cast<void>(texture.felt(memory, kUp, 1, Vec3(0)));
  EXPECT_LT(glm::length(texture.felt(memory, kUp, 1, Vec3(0)).force_N), 1e-12);
  for (const double speed : {0.005, 0.01, 0.03, 0.5}) {
    for (const double force_N : {0.1, 0.5, 2.0, 9.0}) {
      const double here = texture.at(speed, force_N).deviation,
                   beside = texture.at(speed + 1e-9, force_N + 1e-9).deviation;
      EXPECT_NEAR(here, beside, 1e-6);
    }
  }
}

TEST(RecordedTexture, SaysThatItStopsWhereAnotherObjectIsTouched) {
  Random random(5);
  const EffectField field(randomGrid(random));
  EffectMemory memory;
  TextureMemory texture;
  const auto felt = [&](Vec3 normal) {
    const EffectField::Felt now = field.feltAlong(memory, texture, normal, 1, Vec3(0.05, 0, 0));
    memory.force_N = now.force_N;
    return now;
  };
  for (int i = 0; i < 500; ++i) EXPECT_FALSE(felt(kUp).jumped);
  ASSERT_NE(memory.force_N, Vec3(0));
  EXPECT_TRUE(felt(Vec3(0)).jumped);
  EXPECT_FALSE(felt(Vec3(0)).jumped);
}

}  // namespace
}  // namespace haptics::recorded_texture_test
