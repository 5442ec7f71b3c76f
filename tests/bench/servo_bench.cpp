#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <thread>

#include "haptic_server/servo/realtime.h"
#include "haptic_server/servo/servo_loop.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenes.h"
#include "tests/bench/stopwatch.h"

namespace haptics::bench {
namespace {

constexpr double kRate_Hz = 1000;
constexpr std::uint64_t kWarmUp = 200;  // ticks
constexpr std::uint64_t kTicks = 3000;

/// A hand that is led along a scene's path, and a clock between its position and the force.
class TimedDevice final : public Device {
 public:
  explicit TimedDevice(const Scene& scene) : scene_(scene) { stopwatch_.reserve(kTicks); }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceReading read(std::uint64_t) noexcept override {
    const std::size_t i = reads_++;
    const std::size_t approach = scene_.approach.size();
    const Vec3 place = i < approach ? scene_.approach[i] : scene_.path[(i - approach) % scene_.path.size()];
    began_ = Clock::now();
    return {place, DeviceState::kReady};
  }
  void write(Vec3) noexcept override {
    const Clock::time_point now = Clock::now();
    if (reads_ > scene_.approach.size() + kWarmUp) stopwatch_.record(now - began_);
  }
  void stop() noexcept override {}
  void report(benchmark::State& state) { stopwatch_.report(state); }

 private:
  DeviceInfo info_{"led", 3.3, 0, 0, 0};
  const Scene& scene_;
  std::size_t reads_ = 0;
  Clock::time_point began_;
  Stopwatch stopwatch_;
};

/// Device read to force written in the server's loop, which sleeps between ticks.
void sleepingLoop(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments, bool cacheWarmer) {
  const Scene path = trajectory.make(segments);
  TimedDevice device(path);
  SceneMailbox mailbox;
  auto scene = std::make_unique<ServoScene>();
  scene->revision = 1;
  scene->objects.push_back({1, sphere(segments), {}, 1000, 0.5, false});
  mailbox.publish(std::move(scene));
  const auto loop = std::make_unique<ServoLoop>(device, mailbox, kRate_Hz, cacheWarmer);
  for (auto _ : state) {
    std::thread([&] {
      RealtimeStatus realtime;
      configureServoThread(std::nullopt, realtime);
      const std::atomic<bool> stop{false};
      loop->run(stop, path.approach.size() + kWarmUp + kTicks);
    }).join();
  }
  device.report(state);
  state.counters["tick_p50_ns"] = static_cast<double>(loop->statistics().tick_ns.quantile_ns(0.5));
  state.counters["tick_p99_ns"] = static_cast<double>(loop->statistics().tick_ns.quantile_ns(0.99));
}

}  // namespace

void registerServo(std::span<const std::uint32_t> sizes) {
  for (const std::uint32_t n : sizes) {
    for (const Trajectory& t : {kRubbing, kSlide, kFreeSpace}) {
      for (const bool cacheWarmer : {false, true}) {
        const std::string name = std::string("sleeping_loop_1kHz/") + (cacheWarmer ? "pre_touch/" : "no_pre_touch/") +
                                 t.name + "/triangles:" + std::to_string(triangleCount(n));
        benchmark::RegisterBenchmark(name.c_str(), sleepingLoop, t, n, cacheWarmer)->Iterations(1)->UseRealTime();
      }
    }
  }
}

}  // namespace haptics::bench
