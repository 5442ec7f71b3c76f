#include "tests/eval/timing.h"

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <fstream>

namespace haptics::eval {
namespace {

// This processor's own: the C library's sysconf() adds up those of a large machine.
std::size_t lastLevelCache_bytes() {
  constexpr std::size_t kWhereUnknown_KiB = 32 << 10;
  std::size_t kibibytes = 0;
  std::ifstream("/sys/devices/system/cpu/cpu0/cache/index3/size") >> kibibytes;
  return (kibibytes > 0 ? kibibytes : kWhereUnknown_KiB) << 10;
}

}  // namespace

Stopwatch::Stopwatch() {
  constexpr int kRounds = 1001;
  for (int i = 0; i < kRounds; ++i) time([] { asm volatile("" ::: "memory"); });
  clock_ns_ = durations_ns_.quantile(0.5);
  durations_ns_ = {};
}

double threadTime_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

void sweepCaches() {
  constexpr std::size_t kCacheLine_bytes = 64;
  static std::vector<std::uint8_t> buffer(2 * lastLevelCache_bytes());
  for (std::size_t i = 0; i < buffer.size(); i += kCacheLine_bytes) ++buffer[i];
  asm volatile("" ::: "memory");
}

}  // namespace haptics::eval
