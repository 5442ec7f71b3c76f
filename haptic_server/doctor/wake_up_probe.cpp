#include "haptic_server/doctor/wake_up_probe.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <thread>

#include "common/clock/monotonic.h"
#include "haptic_server/servo/latency_histogram.h"

namespace haptics {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

void sleepUntil(std::uint64_t deadline_ns) noexcept {
  const timespec deadline{static_cast<time_t>(deadline_ns / kSecond_ns), static_cast<long>(deadline_ns % kSecond_ns)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace

WakeUps measureWakeUps(double seconds, double rate_Hz, std::optional<int> cpu) {
  WakeUps result;
  for (const std::uint64_t us : {5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10'000})
    result.bins.push_back({us * 1000});
  result.bins.push_back({std::numeric_limits<std::uint64_t>::max()});
  lockMemory(result.realtime);
  const CpuIdleInhibitor wakeful(result.realtime);
  const auto histogram = std::make_unique<LatencyHistogram>();
  const auto period_ns = static_cast<std::uint64_t>(std::llround(1e9 / rate_Hz));
  const auto end = static_cast<std::uint64_t>(std::llround(seconds * rate_Hz));
  std::thread servo([&] {
    configureServoThread(cpu, result.realtime);
    const std::uint64_t start_ns = monotonicNow_ns() + period_ns;
    for (std::uint64_t i = 0; i < end; ++i) {
      sleepUntil(start_ns + i * period_ns);
      const std::uint64_t late_ns = monotonicNow_ns() - (start_ns + i * period_ns);
      histogram->record(late_ns);
      ++std::ranges::find_if(result.bins, [late_ns](const auto& bin) { return late_ns < bin.below_ns; })->count;
      ++result.count;
      if (late_ns >= period_ns) ++result.late;
      i += late_ns / period_ns;  // slept through
    }
  });
  servo.join();
  result.p50_ns = histogram->quantile_ns(0.5);
  result.p99_ns = histogram->quantile_ns(0.99);
  result.p999_ns = histogram->quantile_ns(0.999);
  result.max_ns = histogram->max_ns();
  return result;
}

}  // namespace haptics
