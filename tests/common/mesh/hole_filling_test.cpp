#include "common/mesh/hole_filling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace haptics::hole_filling_test {
namespace {

const auto kNothingTaken = [](std::uint32_t, std::uint32_t) { return false; };

std::optional<std::vector<TriangleIndices>> fill(const std::vector<Vec3f>& vertices, const Rim& rim,
                                                 const std::function<bool(std::uint32_t, std::uint32_t)>& isTaken) {
  Work work(1'000'000'000);
  return fillHole(vertices, rim, isTaken, work);
}

Vec3 areaNormal(const std::vector<Vec3f>& vertices, const TriangleIndices& t) {
  const Vec3 a(vertices[t[0]]);
  return glm::cross(Vec3(vertices[t[1]]) - a, Vec3(vertices[t[2]]) - a);
}

/// Corners `at` in a ring, in a flat surface that faces up.
Rim flatRim(std::size_t count) {
  Rim rim;
  for (std::uint32_t i = 0; i < count; ++i) rim.corners.push_back(i);
  rim.beside.assign(count, Vec3(0, 0, 1));
  return rim;
}

TEST(HoleFilling, ClosesAFlatHoleFlatlyWhateverItsShape) {
  for (const std::uint32_t count : {3U, 4U, 9U, 40U}) {
    std::vector<Vec3f> star;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      const double radius = i % 2 == 0 || count < 9 ? 1 : 0.3;
      star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
    }
    double expected = 0;  // twice the area
    for (std::uint32_t i = 0; i < count; ++i) expected += glm::cross(Vec3(star[i]), Vec3(star[(i + 1) % count])).z;
    const auto triangles = fill(star, flatRim(count), kNothingTaken);
    ASSERT_TRUE(triangles) << count;
    EXPECT_EQ(triangles->size(), count - 2);
    double area = 0;
    for (const auto& t : *triangles) {
      EXPECT_GT(areaNormal(star, t).z, 0);
      area += areaNormal(star, t).z;
    }
    EXPECT_NEAR(area, expected, 1e-6);
  }
}

/// All ways to fill the part of a rim from corner i to corner k.
std::vector<std::vector<TriangleIndices>> allFillings(std::uint32_t i, std::uint32_t k) {
  if (k - i < 2) return {{}};
  std::vector<std::vector<TriangleIndices>> all;
  for (std::uint32_t j = i + 1; j < k; ++j) {
    for (const auto& left : allFillings(i, j)) {
      for (const auto& right : allFillings(j, k)) {
        all.push_back(left);
        all.back().insert(all.back().end(), right.begin(), right.end());
        all.back().push_back({i, j, k});
      }
    }
  }
  return all;
}

/// The smallest cosine between normals across a line.
double sharpestFold(const std::vector<Vec3f>& vertices, const Rim& rim, const std::vector<TriangleIndices>& filling) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> across;
  const auto count = static_cast<std::uint32_t>(rim.corners.size());
  for (std::uint32_t i = 0; i < count; ++i) across[{(i + 1) % count, i}] = rim.beside[i];
  for (const auto& t : filling) {
    for (std::size_t k = 0; k < 3; ++k) across[{t[k], t[(k + 1) % 3]}] = areaNormal(vertices, t);
  }
  double cosine = 1;
  for (const auto& [line, normal] : across) {
    const Vec3 other = across.at({line.second, line.first});
    cosine = std::min(cosine, glm::dot(glm::normalize(normal), glm::normalize(other)));
  }
  return cosine;
}

TEST(HoleFilling, FoldsMoreBluntlyThanMostFillings) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(-1, 1);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Vec3f> vertices(7);
    for (Vec3f& v : vertices) v = Vec3f(place(random), place(random), place(random));
    Rim rim = flatRim(7);
    for (Vec3& normal : rim.beside) normal = Vec3(place(random), place(random), place(random));
    const auto fillings = allFillings(0, 6);
    const auto filled = fill(vertices, rim, kNothingTaken);
    ASSERT_TRUE(filled);
    const double own = sharpestFold(vertices, rim, *filled);
    EXPECT_GT(std::ranges::count_if(fillings, [&](const auto& f) { return sharpestFold(vertices, rim, f) <= own; }),
              static_cast<std::ptrdiff_t>(fillings.size() * 3 / 4));
  }
}

TEST(HoleFilling, UsesNoLineThatIsThereAlready) {
  const std::vector<Vec3f> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (const std::uint32_t taken : {0U, 1U}) {
    const auto triangles = fill(square, flatRim(4), [taken](std::uint32_t a, std::uint32_t) { return a == taken; });
    ASSERT_TRUE(triangles);
    for (const auto& t : *triangles) {
      const bool namesBoth = (t[0] == taken || t[1] == taken || t[2] == taken) &&
                             (t[0] == taken + 2 || t[1] == taken + 2 || t[2] == taken + 2);
      EXPECT_FALSE(namesBoth);
    }
  }
  EXPECT_FALSE(fill(square, flatRim(4), [](std::uint32_t, std::uint32_t) { return true; }));
}

TEST(HoleFilling, GivesUpWhereNoTriangleHasAreaAndOnRimsThatAreTooLong) {
  EXPECT_FALSE(fill({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, flatRim(4), kNothingTaken));
  EXPECT_FALSE(fill({{0, 0, 0}, {1, 0, 0}}, flatRim(2), kNothingTaken));
  std::vector<Vec3f> round;
  for (std::size_t i = 0; i <= kMaxCorners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / (kMaxCorners + 1);
    round.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  EXPECT_FALSE(fill(round, flatRim(kMaxCorners + 1), kNothingTaken));
}

TEST(HoleFilling, GivesUpWhenTheWorkDoesNotSuffice) {
  std::vector<Vec3f> round;
  for (std::size_t i = 0; i < kMaxCorners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kMaxCorners;
    round.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  Work little(10'000);
  EXPECT_FALSE(fillHole(round, flatRim(kMaxCorners), kNothingTaken, little));
  EXPECT_GT(little.left(), -10'000) << "at once";
  EXPECT_TRUE(fill(round, flatRim(kMaxCorners), kNothingTaken));
}

}  // namespace
}  // namespace haptics::hole_filling_test
