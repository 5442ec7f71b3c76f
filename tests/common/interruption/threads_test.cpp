#include "common/interruption/threads.h"

#include <gtest/gtest.h>

#include <atomic>
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

}  // namespace
}  // namespace haptics::threads_test
