#include "common/wire/udp.h"

#include <gmock/gmock.h>

#include <chrono>
#include <new>
#include <string>
#include <vector>

namespace haptics::udp_test {
namespace {

class Udp : public testing::Test {
 protected:
  void serveUntil(const std::function<bool()>& condition) {
    const Timer look = loop.every(std::chrono::milliseconds(1), [&] {
      if (condition()) loop.stop();
    });
    const Timer limit = loop.after(std::chrono::seconds(30), [&] { loop.stop(); });
    loop.run();
    ASSERT_TRUE(condition()) << "not within 30 s";
  }

  EventLoop loop;
};

TEST_F(Udp, CarriesDatagramsBothWaysAndSaysWhoseTheyAre) {
  std::string heard;
  std::unique_ptr<DatagramSocket> server;
  auto opened = DatagramSocket::open(
      loop, {"127.0.0.1", 0}, [&](std::span<const char> bytes, const Endpoint& from) { server->send(bytes, from); });
  ASSERT_TRUE(opened) << opened.error().text();
  server = *std::move(opened);
  Endpoint answeredBy;
  const auto client =
      DatagramSocket::towards(loop, server->local(), [&](std::span<const char> b, const Endpoint& from) {
        heard.assign(b.data(), b.size());
        answeredBy = from;
      });
  ASSERT_TRUE(client) << client.error().text();
  (*client)->send(std::string("echo"), server->local());
  serveUntil([&] { return !heard.empty(); });
  EXPECT_EQ(heard, "echo");
  EXPECT_EQ(answeredBy, server->local());
}

TEST_F(Udp, ShowsThatADatagramWasTooLarge) {
  std::size_t size = 0;
  const auto server =
      DatagramSocket::open(loop, {"127.0.0.1", 0}, [&](auto bytes, const Endpoint&) { size = bytes.size(); });
  ASSERT_TRUE(server);
  const auto client = DatagramSocket::towards(loop, (*server)->local(), [](auto, const Endpoint&) {});
  (*client)->send(std::string(5000, 'x'), (*server)->local());
  serveUntil([&] { return size != 0; });
  EXPECT_EQ(size, kMaxDatagramBytes + 1);
}

TEST_F(Udp, SurvivesSendingWhereNobodyListens) {
  Endpoint nobody;
  {
    const auto gone = DatagramSocket::open(loop, {"127.0.0.1", 0}, [](auto, const Endpoint&) {});
    nobody = (*gone)->local();
  }
  std::vector<std::string> heard;
  const auto socket = DatagramSocket::open(
      loop, {"127.0.0.1", 0}, [&](auto bytes, const Endpoint&) { heard.emplace_back(bytes.data(), bytes.size()); });
  (*socket)->send(std::string("lost"), nobody);
  (*socket)->send(std::string("to oneself"), (*socket)->local());
  serveUntil([&] { return !heard.empty(); });
  EXPECT_THAT(heard, testing::ElementsAre("to oneself"));
}

TEST_F(Udp, GoesOnAfterAnErrorOfItsReceiver) {
  int heard = 0;
  const auto socket = DatagramSocket::open(loop, {"127.0.0.1", 0}, [&](auto, const Endpoint&) {
    if (++heard == 1) throw std::bad_alloc();
  });
  (*socket)->send(std::string("one"), (*socket)->local());
  EXPECT_THROW(loop.run(), std::bad_alloc);
  (*socket)->send(std::string("two"), (*socket)->local());
  serveUntil([&] { return heard == 2; });
}

TEST_F(Udp, SaysThatAPortIsInUse) {
  const auto first = DatagramSocket::open(loop, {"127.0.0.1", 0}, [](auto, const Endpoint&) {});
  const auto second = DatagramSocket::open(loop, (*first)->local(), [](auto, const Endpoint&) {});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().field, testing::HasSubstr((*first)->local().text()));
}

}  // namespace
}  // namespace haptics::udp_test
