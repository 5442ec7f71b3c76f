#include "tests/eval/timing.h"

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <ctime>

namespace haptics::eval {

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
  constexpr long kWhereUnknown_bytes = 32L << 20;
  static std::vector<std::uint8_t> buffer(
      2 * static_cast<std::size_t>(std::max(kWhereUnknown_bytes, sysconf(_SC_LEVEL3_CACHE_SIZE))));
  for (std::size_t i = 0; i < buffer.size(); i += kCacheLine_bytes) ++buffer[i];
  asm volatile("" ::: "memory");
}

}  // namespace haptics::eval
