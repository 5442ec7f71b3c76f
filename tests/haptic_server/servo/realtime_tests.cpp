#include <gtest/gtest.h>
#include <pthread.h>

#include <thread>

#include "haptic_server/servo/realtime.h"

namespace haptics::realtime_tests {
namespace {

TEST(KeepStacksSmall, HoldsForThreadsThatStartLater) {
  pthread_attr_t before;
  ASSERT_EQ(pthread_getattr_default_np(&before), 0);
  keepStacksSmall();
  std::size_t stack_bytes = 0;
  std::thread([&] {
    pthread_attr_t own;
    pthread_getattr_np(pthread_self(), &own);
    pthread_attr_getstacksize(&own, &stack_bytes);
    pthread_attr_destroy(&own);
  }).join();
  EXPECT_EQ(stack_bytes, 2U << 20);
  pthread_setattr_default_np(&before);
  pthread_attr_destroy(&before);
}

}  // namespace
}  // namespace haptics::realtime_tests
