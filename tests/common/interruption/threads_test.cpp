#include "common/interruption/threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <ctime>
#include <new>

namespace haptics::threads_test {
namespace {

TEST(Threads, AreAllInterruptible) {
  std::stop_source stop;
  const Interruptible here(stop.get_token());
  std::atomic<int> begun{0}, ended{0};
  EXPECT_THROW(runInThreads(3,
                            [&] {
                              if (++begun == 3) stop.request_stop();
                              try {
                                while (true) interruptionPoint();
                              } catch (...) {
                                ++ended;
                                throw;
                              }
                            }),
               Interrupted);
  EXPECT_EQ(ended, 3);
}

TEST(Threads, GiveTheCallerWhatAnotherThrows) {
  const std::thread::id caller = std::this_thread::get_id();
  EXPECT_THROW(runInThreads(2,
                            [&] {
                              if (std::this_thread::get_id() != caller) throw std::bad_alloc();
                            }),
               std::bad_alloc);
}

TEST(Threads, AreOneWhereNoMoreAreAskedFor) {
  int calls = 0;
  runInThreads(1, [&] { ++calls; });
  EXPECT_EQ(calls, 1);
}

double threadTime_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void work(double time_s) {
  for (const double end_s = threadTime_s() + time_s; threadTime_s() < end_s;) continue;
}

TEST(WorkMeter, CountsTheProcessorsOfAllThreadsThatAreAtIt) {
  constexpr double kEach_s = 0.02;
  WorkMeter meter;
  work(kEach_s);
  EXPECT_EQ(meter.time_s(), 0);
  {
    const WorkMeter::Counting counting(&meter);
    std::atomic<int> begun{0};
    runInThreads(3, [&] {
      work(kEach_s);
      ++begun;
      while (begun < 3) std::this_thread::yield();
      EXPECT_GE(meter.time_s(), 3 * kEach_s) << "while they are at it";
    });
    const WorkMeter::Counting others(nullptr);
    runInThreads(2, [&] { work(kEach_s); });
  }
  const double all_s = meter.time_s();
  EXPECT_GE(all_s, 3 * kEach_s);
  work(kEach_s);
  EXPECT_EQ(meter.time_s(), all_s);
  EXPECT_EQ(WorkMeter::current(), nullptr);
}

}  // namespace
}  // namespace haptics::threads_test
