#include "common/surface/makers/grown_reaction_diffusion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/interruption/interruption.h"
#include "common/mesh/generators.h"
#include "common/surface/makers/even_samples.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/makers/spot_noise.h"
#include "common/surface/point_field_asset.h"
#include "tests/common/surface/field_checks.h"

namespace haptics::grown_reaction_diffusion_test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;
using Pattern = ReactionDiffusionSource::Pattern;

constexpr double kWavelength_m = 0.006;

TriMesh sphere() { return makeSphere(0.02, 20).value(); }
TriMesh doughnut() { return makeTorus(0.024, 0.009, 60, 30).value(); }
/// Of uneven triangles, with hollows, and ears that no cylinder or sphere fits.
TriMesh blob() {
  TriMesh mesh = makeSphere(0.016, 24).value();
  for (Vec3f& vertex : mesh.vertices) {
    const Vec3 out = glm::normalize(Vec3(vertex));
    const auto ear = [&](Vec3 to) { return 0.9 * std::pow(std::max(0.0, glm::dot(out, glm::normalize(to))), 24); };
    const double scale =
        1 + 0.15 * std::sin(5 * out.x) * std::cos(4 * out.y + 1) + ear({1, 0.3, 1}) + ear({-0.8, 0.5, 1});
    vertex = Vec3f(scale * Vec3(vertex));
  }
  return mesh;
}

PointField spots(const TriMesh& mesh, std::uint32_t seed = 1) {
  return grownReactionDiffusion(mesh, {Pattern::kSpots, kWavelength_m, seed}).value();
}

/// Samples that are higher than all others within half a wavelength.
std::vector<PointSample> maximaOf(const PointField& field) {
  std::vector<PointSample> maxima;
  for (const PointSample& sample : field.samples()) {
    const bool isHighest = std::ranges::all_of(field.samples(), [&](const PointSample& other) {
      return other.value <= sample.value || glm::distance(other.point, sample.point) > 0.5 * kWavelength_m;
    });
    if (isHighest && sample.value > 0) maxima.push_back(sample);
  }
  return maxima;
}

TEST(EvenSamples, AreAsManyAsAskedForAndNoTwoNearEachOther) {
  const TriMesh mesh = sphere();
  const auto samples = evenSamples(mesh, 800, 1).value();
  ASSERT_EQ(samples.size(), 800U);
  const double spacing_m = evenSpacing_m(areaOf_m2(mesh), 800);
  EXPECT_NEAR(areaOf_m2(mesh), 4 * pi * 0.02 * 0.02, 1e-5);
  double mean_m = 0;
  for (const MeshSample& sample : samples) {
    EXPECT_NEAR(glm::length(sample.point), 0.02, 1e-4);
    EXPECT_GT(glm::dot(sample.normal, glm::normalize(sample.point)), 0.99);
    double nearest_m = 1;
    for (const MeshSample& other : samples) {
      if (&other != &sample) nearest_m = std::min(nearest_m, glm::distance(other.point, sample.point));
    }
    EXPECT_GT(nearest_m, 0.6 * spacing_m);
    EXPECT_LT(nearest_m, 1.2 * spacing_m);
    mean_m += nearest_m / 800;
  }
  EXPECT_GT(mean_m, 0.75 * spacing_m) << "half of it if they were at random";
}

TEST(EvenSamples, AreAsDenseOnLargeTrianglesAsOnSmallOnes) {
  TriMesh mesh = makeBox(Vec3(0.04, 0.04, 0.001), 1).value();
  const TriMesh fine = makeBox(Vec3(0.02, 0.02, 0.02), 40).value();
  const auto start = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3f vertex : fine.vertices) mesh.vertices.push_back(vertex + Vec3f(1, 0, 0));
  for (const TriangleIndices& t : fine.triangles) mesh.triangles.push_back({start + t[0], start + t[1], start + t[2]});
  const auto samples = evenSamples(mesh, 1000, 2).value();
  const auto onFine = std::ranges::count_if(samples, [](const MeshSample& s) { return s.point.x > 0.5; });
  const double share = areaOf_m2(fine) / areaOf_m2(mesh);
  EXPECT_NEAR(static_cast<double>(onFine), 1000 * share, 40);
}

TEST(Neighborhoods, AreThoseWithinTheRadiusOnTheSameSideAndMutual) {
  const auto samples = evenSamples(makeBox(Vec3(0.03, 0.03, 0.0004), 4).value(), 500, 1).value();
  const auto near = neighborhoodsOf(samples, 0.003).value();
  ASSERT_EQ(near.first.size(), samples.size() + 1);
  std::size_t across = 0;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    std::vector<std::uint32_t> found, expected;
    for (std::size_t n = near.first[i]; n < near.first[i + 1]; ++n) found.push_back(near.all[n].sample);
    for (std::uint32_t j = 0; j < samples.size(); ++j) {
      if (j == i || glm::distance(samples[i].point, samples[j].point) >= 0.003) continue;
      if (glm::dot(samples[i].normal, samples[j].normal) < -0.9) {
        ++across;
      } else {
        expected.push_back(j);
      }
    }
    std::ranges::sort(found);
    EXPECT_EQ(found, expected);
  }
  EXPECT_GT(across, samples.size()) << "there are two sides";
}

TEST(GrownReactionDiffusion, HasSpotsAsFarApartAsAskedForWhateverTheShape) {
  for (const auto& [name, mesh] : {std::pair{"sphere", sphere()}, {"doughnut", doughnut()}, {"blob", blob()}}) {
    const auto count = maximaOf(spots(mesh)).size();
    // Of as many in a hexagonal grid.
    EXPECT_NEAR(evenSpacing_m(areaOf_m2(mesh), count), kWavelength_m, 0.15 * kWavelength_m) << name << ' ' << count;
  }
}

TEST(GrownReactionDiffusion, HasStripesAsFarApartAsAskedFor) {
  const PointField stripes = grownReactionDiffusion(sphere(), {Pattern::kStripes, kWavelength_m, 1}).value();
  int crossings = 0;
  double length_m = 0;
  Random random(3);
  for (int circle = 0; circle < 60; ++circle) {
    const Vec3 from = fixture::randomDirection(random);
    const Vec3 aside = glm::normalize(glm::cross(from, fixture::randomDirection(random)));
    const auto valueAt = [&](double turn) {
      return stripes.at(0.02 * (std::cos(turn) * from + std::sin(turn) * aside)).value;
    };
    for (double turn = 0; turn < 2 * pi; turn += 0.01) crossings += valueAt(turn) * valueAt(turn + 0.01) < 0 ? 1 : 0;
    length_m += 2 * pi * 0.02;
  }
  // A line crosses stripes of all directions: two edges a wavelength, times 2 / pi, the mean of |cos|.
  const double expected = length_m * 2 / kWavelength_m * 2 / pi;
  EXPECT_NEAR(crossings, expected, 0.15 * expected);
}

TEST(GrownReactionDiffusion, HasZeroMeanAndUnitPeakAndSpotsThatStandOut) {
  for (const Pattern pattern : {Pattern::kSpots, Pattern::kStripes}) {
    const PointField field = grownReactionDiffusion(doughnut(), {pattern, kWavelength_m, 2}).value();
    double sum = 0, squares = 0, cubes = 0, largest = 0;
    for (const PointSample& sample : field.samples()) {
      const double value = sample.value;
      sum += value;
      squares += value * value;
      cubes += value * value * value;
      largest = std::max(largest, std::abs(value));
    }
    const auto count = static_cast<double>(field.samples().size());
    EXPECT_EQ(largest, 1);
    EXPECT_NEAR(sum / count, 0, 1e-7);
    const double skewness = cubes / count / std::pow(squares / count, 1.5);
    if (pattern == Pattern::kSpots) {
      EXPECT_GT(skewness, 0.6);
    } else {
      EXPECT_NEAR(skewness, 0, 0.25);
    }
    EXPECT_GT(field.bounds().highest, 0.6) << "what is between samples shows the pattern";
  }
}

TEST(GrownReactionDiffusion, HasNoSeamRoundADoughnut) {
  const PointField field = spots(doughnut(), 3);
  constexpr int kSectors = 8;
  std::vector<double> counts(kSectors, 0), squares(kSectors, 0);
  for (const PointSample& sample : field.samples()) {
    const double turn = std::atan2(sample.point.y, sample.point.x) / (2 * pi) + 0.5;
    const auto sector = std::min<std::size_t>(kSectors - 1, static_cast<std::size_t>(kSectors * turn));
    counts[sector] += 1;
    squares[sector] += sample.value * sample.value;
  }
  double mean = 0;
  for (std::size_t i = 0; i < kSectors; ++i) mean += std::sqrt(squares[i] / counts[i]) / kSectors;
  for (std::size_t i = 0; i < kSectors; ++i) {
    EXPECT_NEAR(counts[i] * kSectors, static_cast<double>(field.samples().size()),
                0.1 * static_cast<double>(field.samples().size()));
    EXPECT_NEAR(std::sqrt(squares[i] / counts[i]), mean, 0.25 * mean) << "contrast of sector " << i;
  }
  // Between neighbours everywhere, the start and the end of the turn included, the step is that of the pattern.
  for (const PointSample& a : field.samples()) {
    for (const PointSample& b : field.samples()) {
      const double away = glm::distance(a.point, b.point) / kWavelength_m;
      if (away < 0.15) {
        EXPECT_LT(std::abs(a.value - b.value), 2 * pi * 1.5 * away + 0.02);
      }
    }
  }
}

TEST(GrownReactionDiffusion, KeepsTheSidesOfAThinSheetApart) {
  const PointField field =
      grownReactionDiffusion(makeBox(Vec3(0.05, 0.05, 0.0004), 8).value(), {Pattern::kSpots, 0.004, 1}).value();
  std::vector<PointSample> upper, lower;
  for (const PointSample& sample : field.samples()) {
    if (std::max(std::abs(sample.point.x), std::abs(sample.point.y)) > 0.02F) continue;
    (sample.point.z > 0 ? upper : lower).push_back(sample);
  }
  double product = 0, squares = 0;
  for (const PointSample& sample : upper) {
    const auto below = std::ranges::min_element(
        lower, {}, [&](const PointSample& other) { return glm::distance(other.point, sample.point); });
    product += sample.value * below->value;
    squares += sample.value * sample.value;
  }
  EXPECT_LT(std::abs(product / squares), 0.3) << "1 if they were one";
}

TEST(GrownReactionDiffusion, DiffersBySeedAndIsTheSameOnEveryMachine) {
  const TriMesh mesh = makeTorus(0.02, 0.008, 20, 12).value();
  const auto hash = [&](Pattern pattern, std::uint32_t seed) {
    return hashOf(grownReactionDiffusion(mesh, {pattern, 0.01, seed}).value()).hex();
  };
  EXPECT_NE(hash(Pattern::kSpots, 1), hash(Pattern::kSpots, 2));
  EXPECT_EQ(hash(Pattern::kSpots, 1), "91c5699dfdc1b8e818c6fbec4bbc20bf5c8a4a344b7ff2293ce0ec795a42fff5");
  EXPECT_EQ(hash(Pattern::kStripes, 1), "ac6e395664d8db482eb192e39ee80031423f779a31ee57b6860ff72a8ce75c87");
}

TEST(GrownReactionDiffusion, IsRefusedWithAWavelengthThatTakesTooManySamplesOrTooFew) {
  const auto refusal = [](double wavelength_m) {
    const auto made = grownReactionDiffusion(sphere(), {Pattern::kSpots, wavelength_m, 1});
    return made ? Error{"accepted", ""} : made.error();
  };
  const double area_m2 = areaOf_m2(sphere());
  const double least_m = 7 * evenSpacing_m(area_m2, 60'000), most_m = 7 * evenSpacing_m(area_m2, 100);
  const Error fine = refusal(0.99 * least_m), coarse = refusal(1.01 * most_m);
  EXPECT_EQ(fine.field, "reaction_diffusion.wavelength_m");
  EXPECT_THAT(fine.reason, HasSubstr("at most 60000 are taken: give "));
  EXPECT_EQ(coarse.field, "reaction_diffusion.wavelength_m");
  EXPECT_THAT(coarse.reason, HasSubstr("no pattern: give "));
  const auto named = [](const Error& error) {
    return std::stod(error.reason.substr(error.reason.find("give ") + std::string("give ").size()));
  };
  EXPECT_GT(named(fine), least_m);
  EXPECT_LT(named(fine), 1.05 * least_m);
  EXPECT_EQ(refusal(named(coarse)).field, "accepted");
  EXPECT_GT(named(coarse), 0.95 * most_m);
}

TEST(GrownReactionDiffusion, IsRefusedOnAMeshThatReachesBeyondWhatAFieldHolds) {
  TriMesh far = makeBox(Vec3(0.1), 1).value();
  for (Vec3f& vertex : far.vertices) vertex.x += 2000;
  EXPECT_EQ(grownReactionDiffusion(far, {Pattern::kSpots, 0.02, 1}).error().field, "reaction_diffusion");
}

TEST(GrownReactionDiffusion, IsRefusedWhereManySheetsLieAboveEachOther) {
  const TriMesh sheet = makeBox(Vec3(0.01, 0.01, 0.00001), 1).value();
  TriMesh stack;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const auto start = static_cast<std::uint32_t>(stack.vertices.size());
    for (const Vec3f vertex : sheet.vertices)
      stack.vertices.push_back(vertex + Vec3f(0, 0, 1e-6F * static_cast<float>(i)));
    for (const TriangleIndices& t : sheet.triangles)
      stack.triangles.push_back({start + t[0], start + t[1], start + t[2]});
  }
  const auto made = grownReactionDiffusion(stack, {Pattern::kSpots, 0.02, 1});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().reason, HasSubstr("shorter"));
}

TEST(Makers, MayBeInterrupted) {
  std::stop_source stop;
  stop.request_stop();
  const Interruptible work(stop.get_token());
  EXPECT_THROW(static_cast<void>(grownReactionDiffusion(sphere(), {.wavelength_m = kWavelength_m})), Interrupted);
  EXPECT_THROW(static_cast<void>(reactionDiffusion({})), Interrupted);
  EXPECT_THROW(static_cast<void>(spotNoise({})), Interrupted);
}

}  // namespace
}  // namespace haptics::grown_reaction_diffusion_test
