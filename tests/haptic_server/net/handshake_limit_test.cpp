#include <gtest/gtest.h>

#include "haptic_server/net/rate_limit.h"

namespace haptics::handshake_limit_test {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

int allowed(HandshakeLimit& limit, const std::string& host, int asked, std::uint64_t now_ns) {
  int count = 0;
  for (int i = 0; i < asked; ++i) count += limit.allow(host, now_ns) ? 1 : 0;
  return count;
}

TEST(HandshakeLimit, HoldsBackAHostThatKeepsConnectingAndNobodyElse) {
  HandshakeLimit limit;
  EXPECT_EQ(allowed(limit, "10.0.0.1", 1000, kSecond_ns), 100);
  EXPECT_EQ(allowed(limit, "10.0.0.2", 5, kSecond_ns), 5);
  EXPECT_EQ(allowed(limit, "10.0.0.1", 1000, 2 * kSecond_ns), 20);
}

TEST(HandshakeLimit, RemembersABoundedNumberOfHosts) {
  HandshakeLimit limit;
  EXPECT_EQ(allowed(limit, "first", 101, kSecond_ns), 100);
  for (std::size_t i = 1; i < HandshakeLimit::kMaxHosts; ++i) EXPECT_TRUE(limit.allow(std::to_string(i), kSecond_ns));
  EXPECT_FALSE(limit.allow("first", kSecond_ns)) << "is still remembered";
  EXPECT_TRUE(limit.allow("one more", kSecond_ns));
  EXPECT_TRUE(limit.allow("first", kSecond_ns));
}

}  // namespace
}  // namespace haptics::handshake_limit_test
