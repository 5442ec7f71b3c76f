#include "common/wire/event_loop.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace haptics::event_loop_test {
namespace {

using std::chrono::milliseconds;

TEST(EventLoop, RunsPostedTasksInTheirOrder) {
  EventLoop loop;
  std::vector<int> order;
  for (const int i : {1, 2, 3}) loop.post([&order, i] { order.push_back(i); });
  loop.post([&] { loop.stop(); });
  loop.run();
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3}));
}

TEST(EventLoop, TakesTasksFromOtherThreads) {
  EventLoop loop;
  int count = 0;
  std::thread poster([&] {
    for (int i = 0; i < 100; ++i) loop.post([&count] { ++count; });
    loop.post([&] { loop.stop(); });
  });
  loop.run();
  poster.join();
  EXPECT_EQ(count, 100);
}

TEST(EventLoop, CanRunAgainAfterStop) {
  EventLoop loop;
  for (int round = 0; round < 3; ++round) {
    bool ran = false;
    loop.post([&] {
      ran = true;
      loop.stop();
    });
    loop.run();
    EXPECT_TRUE(ran);
  }
}

TEST(Timer, FiresOnceAfterItsDelay) {
  EventLoop loop;
  const auto start = std::chrono::steady_clock::now();
  const Timer timer = loop.after(milliseconds(5), [&] { loop.stop(); });
  loop.run();
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(5));
}

TEST(Timer, RepeatsUntilItIsDestroyed) {
  EventLoop loop;
  int count = 0;
  Timer timer;
  Timer end;
  timer = loop.every(milliseconds(1), [&] {
    if (++count < 3) return;
    timer = {};  // from within its own task
    end = loop.after(milliseconds(20), [&] { loop.stop(); });
  });
  loop.run();
  EXPECT_EQ(count, 3);
}

TEST(Timer, IsNotCalledOnceDestroyedEvenWhenItIsDue) {
  EventLoop loop;
  bool called = false;
  Timer victim = loop.after(milliseconds(0), [&] { called = true; });
  loop.post([&] { victim = {}; });
  std::this_thread::sleep_for(milliseconds(2));
  const Timer end = loop.after(milliseconds(10), [&] { loop.stop(); });
  loop.run();
  EXPECT_FALSE(called);
}

TEST(Timer, SkipsThePeriodsThatItMissed) {
  EventLoop loop;
  int count = 0;
  const auto start = std::chrono::steady_clock::now();
  const Timer timer = loop.every(milliseconds(10), [&] {
    ++count;
    if (count == 1) std::this_thread::sleep_for(milliseconds(100));
    if (count == 3) loop.stop();
  });
  loop.run();
  // Made up for, the third would have come right after the sleep, at 110 ms.
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(119));
}

}  // namespace
}  // namespace haptics::event_loop_test
