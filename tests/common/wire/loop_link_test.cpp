#include "common/wire/loop_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <thread>

namespace haptics::loop_link_test {
namespace {

constexpr std::chrono::seconds kPatience{20};

/// A loop on a thread of its own.
struct Side {
  EventLoop loop;
  std::thread thread{[this] { loop.run(); }};
  ~Side() {
    loop.stop();
    thread.join();
  }
  /// Runs the task on the loop's thread and waits for it.
  void here(const std::function<void()>& task) {
    std::promise<void> done;
    loop.post([&] {
      task();
      done.set_value();
    });
    ASSERT_EQ(done.get_future().wait_for(kPatience), std::future_status::ready);
  }
};

struct LoopLink : testing::Test {
  Side client, server;
  std::unique_ptr<Transport> clientEnd, serverEnd;

  LoopLink() { std::tie(clientEnd, serverEnd) = linkLoops(client.loop, server.loop); }
  ~LoopLink() override {
    client.here([this] { clientEnd.reset(); });
    server.here([this] { serverEnd.reset(); });
  }
};

TEST_F(LoopLink, CarriesBytesInOrderBothWaysAndOnTheRightThreads) {
  std::string got;
  std::promise<std::string> answered;
  server.here([&] {
    serverEnd->start({.received =
                          [&](std::span<const char> bytes) {
                            EXPECT_EQ(std::this_thread::get_id(), server.thread.get_id());
                            got.append(bytes.begin(), bytes.end());
                            if (got.size() == 2'000) serverEnd->send(got);
                          },
                      .drained = {},
                      .closed = {}});
  });
  std::string sent, answer;
  client.here([&] {
    clientEnd->start({.received =
                          [&](std::span<const char> bytes) {
                            EXPECT_EQ(std::this_thread::get_id(), client.thread.get_id());
                            answer.append(bytes.begin(), bytes.end());
                            if (answer.size() == sent.size()) answered.set_value(answer);
                          },
                      .drained = {},
                      .closed = {}});
    for (int i = 0; i < 1'000; ++i) {
      const std::string piece{static_cast<char>('a' + i % 26), static_cast<char>('0' + i % 10)};
      sent += piece;
      clientEnd->send(piece);
    }
  });
  auto future = answered.get_future();
  ASSERT_EQ(future.wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(future.get(), sent);
}

TEST_F(LoopLink, KeepsWhatCameBeforeTheStartAndCountsItAsBacklogUntilItIsTaken) {
  std::promise<void> drained;
  client.here([&] {
    clientEnd->start({.received = {}, .drained = [&] { drained.set_value(); }, .closed = {}});
    clientEnd->send("early");
    EXPECT_EQ(clientEnd->backlog(), 5U);
  });
  ASSERT_EQ(drained.get_future().wait_for(kPatience), std::future_status::ready);
  client.here([&] { EXPECT_EQ(clientEnd->backlog(), 0U); });
  std::promise<std::string> got;
  server.here([&] {
    serverEnd->start({.received =
                          [&](std::span<const char> bytes) {
                            got.set_value({bytes.begin(), bytes.end()});
                          },
                      .drained = {},
                      .closed = {}});
  });
  EXPECT_EQ(got.get_future().get(), "early");
}

TEST_F(LoopLink, DeliversWhatWasSentBeforeTheCloseAndTellsBothEnds) {
  std::promise<std::string> theirs, ours;
  std::string got;
  server.here([&] {
    serverEnd->start({.received = [&](std::span<const char> bytes) { got.append(bytes.begin(), bytes.end()); },
                      .drained = {},
                      .closed = [&](const std::string& why) { theirs.set_value(got + "|" + why); }});
  });
  client.here([&] {
    clientEnd->start({.received = {}, .drained = {}, .closed = [&](const std::string& why) { ours.set_value(why); }});
    clientEnd->send("last words");
    clientEnd->close("done");
    clientEnd->send("ignored");
  });
  EXPECT_EQ(theirs.get_future().get(), "last words|closed by the peer");
  EXPECT_EQ(ours.get_future().get(), "done");
}

TEST_F(LoopLink, AnEndThatGoesAwayClosesTheOtherAndIsNotCalledAnyMore) {
  std::promise<std::string> closed;
  client.here([&] {
    clientEnd->start({.received = {}, .drained = {}, .closed = [&](const std::string& why) { closed.set_value(why); }});
  });
  server.here([&] {
    serverEnd->start({.received = [](std::span<const char>) { ADD_FAILURE(); },
                      .drained = [] { ADD_FAILURE(); },
                      .closed = [](const std::string&) { ADD_FAILURE(); }});
    serverEnd->send("x");
    serverEnd.reset();
  });
  EXPECT_EQ(closed.get_future().get(), "closed by the peer");
}

}  // namespace
}  // namespace haptics::loop_link_test
