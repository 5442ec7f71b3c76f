#include "haptic_server/surface_limits_cache.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>
#include <iterator>
#include <limits>

#include "haptic_server/device/presets.h"

namespace haptics::test::surface_limits_cache_test {
namespace {

namespace fs = std::filesystem;

DeviceInfo omni() {
  const DevicePreset preset = findDevicePreset("omni").value();
  DeviceInfo info;
  info.maxForce_N = preset.maxForce_N;
  info.maxStiffness_N_per_m = preset.maxStiffness_N_per_m;
  info.maxDamping_Ns_per_m = preset.maxDamping_Ns_per_m;
  info.resolution_m = preset.resolution_m;
  info.apparentMass_kg = preset.apparentMass_kg;
  info.viscousFriction_Ns_per_m = preset.viscousFriction_Ns_per_m;
  info.coulombFriction_N = preset.coulombFriction_N;
  info.delay_s = 2e-3;
  return info;
}

constexpr double kRate_Hz = 1000;

class SurfaceLimitsCacheTest : public ::testing::Test {
 protected:
  SurfaceLimitsCacheTest() {
    std::string pattern = (fs::temp_directory_path() / "surface-limits-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~SurfaceLimitsCacheTest() override { fs::remove_all(folder_); }

  [[nodiscard]] SurfaceLimitsCache::Found find(const DeviceInfo& device = omni(), double rate_Hz = kRate_Hz,
                                               bool stabilised = true) const {
    return SurfaceLimitsCache(folder_).find(device, rate_Hz, stabilised);
  }
  [[nodiscard]] fs::path file() const { return SurfaceLimitsCache(folder_).fileFor(omni(), kRate_Hz, true); }
  [[nodiscard]] std::string text() const {
    std::ifstream in(file(), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& text) const { std::ofstream(file(), std::ios::binary) << text; }

  fs::path folder_;
};

TEST_F(SurfaceLimitsCacheTest, ReadsToTheBitWhatWasFoundBefore) {
  const auto first = find();
  EXPECT_TRUE(first.searched);
  EXPECT_EQ(first.limits, surfaceLimits(omni(), kRate_Hz, true));
  const auto second = find();
  EXPECT_FALSE(second.searched);
  EXPECT_EQ(second.limits, first.limits);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing else is left in the folder";
}

TEST_F(SurfaceLimitsCacheTest, KeepsEveryDeviceRateAndDelayApart) {
  (void)find();
  using Change = void (*)(DeviceInfo&);
  const Change changes[] = {[](DeviceInfo& d) { d.maxForce_N *= 2; },
                            [](DeviceInfo& d) { d.maxStiffness_N_per_m *= 2; },
                            [](DeviceInfo& d) { d.resolution_m *= 2; },
                            [](DeviceInfo& d) { d.viscousFriction_Ns_per_m *= 2; },
                            [](DeviceInfo& d) { d.coulombFriction_N *= 2; },
                            [](DeviceInfo& d) { d.apparentMass_kg *= 2; },
                            [](DeviceInfo& d) { d.delay_s *= 2; }};
  const SurfaceLimitsCache cache(folder_);
  for (const Change change : changes) {
    DeviceInfo other = omni();
    change(other);
    EXPECT_NE(cache.fileFor(other, kRate_Hz, true), file());
  }
  EXPECT_NE(cache.fileFor(omni(), 2 * kRate_Hz, true), file());
  EXPECT_NE(cache.fileFor(omni(), kRate_Hz, false), file());
  EXPECT_TRUE(find(omni(), kRate_Hz, false).searched);
}

TEST_F(SurfaceLimitsCacheTest, SearchesAnewWhereAFileIsDamagedOrAnothersAndMendsIt) {
  const SurfaceLimits limits = find().limits;
  const std::string sound = text();
  const std::size_t digit = sound.find("0x1.") + 4;
  for (std::size_t length = 0; length < sound.size(); length += 29) {
    write(sound.substr(0, length));
    EXPECT_TRUE(find().searched) << length;
  }
  std::string otherDigit = sound;
  otherDigit[digit] = sound[digit] == '1' ? '2' : '1';
  std::string otherKey = sound;
  otherKey[4] = sound[4] == '0' ? '1' : '0';
  for (const std::string& damaged : {otherDigit, otherKey, sound + "more"}) {
    write(damaged);
    const auto found = find();
    EXPECT_TRUE(found.searched);
    EXPECT_EQ(found.limits, limits);
    EXPECT_EQ(text(), sound);
  }
}

TEST_F(SurfaceLimitsCacheTest, DoesWithoutAFolderThatCannotBeWritten) {
  write("a file");
  const SurfaceLimitsCache inAFile(file() / "haptics");
  EXPECT_EQ(inAFile.find(omni(), kRate_Hz, true).limits, surfaceLimits(omni(), kRate_Hz, true));
  EXPECT_TRUE(SurfaceLimitsCache({}).find(omni(), kRate_Hz, true).searched);
}

TEST_F(SurfaceLimitsCacheTest, KeepsNothingOfADeviceOfUnknownMass) {
  EXPECT_EQ(find(DeviceInfo{}).limits.stiffness_N_per_m, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST(SurfaceLimitsFolder, IsTheUsersCache) {
  ::setenv("HOME", "/home/somebody", 1);
  ::setenv("XDG_CACHE_HOME", "/var/cache", 1);
  EXPECT_EQ(SurfaceLimitsCache::userFolder(), "/var/cache/haptics");
  ::setenv("XDG_CACHE_HOME", "relative", 1);
  EXPECT_EQ(SurfaceLimitsCache::userFolder(), "/home/somebody/.cache/haptics");
  ::unsetenv("XDG_CACHE_HOME");
  ::unsetenv("HOME");
  EXPECT_EQ(SurfaceLimitsCache::userFolder(), "");
}

}  // namespace
}  // namespace haptics::test::surface_limits_cache_test
