#include "common/wire/endpoint.h"

#include <gmock/gmock.h>

namespace haptics::endpoint_test {
namespace {

using testing::HasSubstr;

TEST(ParseEndpoint, ReadsAddressesAndNames) {
  EXPECT_EQ(*parseEndpoint("127.0.0.1:7400"), (Endpoint{"127.0.0.1", 7400}));
  EXPECT_EQ(*parseEndpoint("0.0.0.0:0"), (Endpoint{"0.0.0.0", 0}));
  EXPECT_EQ(*parseEndpoint("[::1]:65535"), (Endpoint{"::1", 65535}));
  EXPECT_EQ(*parseEndpoint("[fe80::2]:1"), (Endpoint{"fe80::2", 1}));
  EXPECT_EQ(*parseEndpoint("lab-3.example.org:7400"), (Endpoint{"lab-3.example.org", 7400}));
}

TEST(ParseEndpoint, TakesLocalhostForThisMachineWithoutAsking) {
  EXPECT_EQ(*parseEndpoint("localhost:7400"), (Endpoint{"127.0.0.1", 7400}));
}

TEST(ParseEndpoint, RefusesEverythingElseAndSaysWhatWouldBeRight) {
  for (const char* text : {"",
                           ":",
                           "7400",
                           "127.0.0.1",
                           "127.0.0.1:",
                           "127.0.0.1:x",
                           "127.0.0.1:65536",
                           "127.0.0.1:-1",
                           "127.0.0.1:+1",
                           "127.0.0.1: 1",
                           "127.0.0.1:1 ",
                           ":7400",
                           "::1:7400",
                           "[::1]",
                           "[::1:7400",
                           "[]:7400",
                           "[127.0.0.1]:7400",
                           "256.0.0.1:7400",
                           "1.2.3:7400",
                           "a b:7400",
                           "host/path:7400",
                           "http://host:7400"}) {
    const auto endpoint = parseEndpoint(text);
    ASSERT_FALSE(endpoint) << text;
    EXPECT_EQ(endpoint.error().field, text);
    EXPECT_THAT(endpoint.error().reason, HasSubstr("HOST:PORT"));
  }
}

TEST(Endpoint, IsWrittenAsItIsRead) {
  for (const char* text : {"127.0.0.1:7400", "[::1]:7400", "host:1"}) EXPECT_EQ(parseEndpoint(text)->text(), text);
}

TEST(IsLoopback, HoldsForThisMachinesOwnAddressesOnly) {
  for (const char* text : {"127.0.0.1:1", "127.9.8.7:1", "[::1]:1", "localhost:1"}) {
    EXPECT_TRUE(isLoopback(*parseEndpoint(text))) << text;
  }
  for (const char* text : {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "128.0.0.1:1", "[fe80::1]:1", "myhost:1"}) {
    EXPECT_FALSE(isLoopback(*parseEndpoint(text))) << text;
  }
}

TEST(CheckListenAddress, RefusesTheNetworkUnlessItIsTrusted) {
  const Endpoint everywhere{"0.0.0.0", 7400};
  const auto refusal = checkListenAddress(everywhere, false);
  ASSERT_FALSE(refusal);
  EXPECT_THAT(refusal.error().text(), HasSubstr("0.0.0.0:7400"));
  EXPECT_THAT(refusal.error().text(), HasSubstr("--allow-insecure-lan"));
  EXPECT_TRUE(checkListenAddress(everywhere, true));
  EXPECT_TRUE(checkListenAddress({"127.0.0.1", 7400}, false));
}

}  // namespace
}  // namespace haptics::endpoint_test
