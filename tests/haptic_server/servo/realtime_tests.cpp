#include <gtest/gtest.h>
#include <pthread.h>

#include "haptic_server/servo/realtime.h"

namespace haptics::realtime_tests {
namespace {

std::size_t stackOf(const pthread_attr_t& attributes) {
  std::size_t stack_bytes = 0;
  pthread_attr_getstacksize(&attributes, &stack_bytes);
  return stack_bytes;
}

TEST(KeepStacksSmall, HoldsForThreadsThatStartLater) {
  pthread_attr_t before, after;
  ASSERT_EQ(pthread_getattr_default_np(&before), 0);
  keepStacksSmall();
  pthread_getattr_default_np(&after);
  EXPECT_EQ(stackOf(after), 2U << 20);
  pthread_setattr_default_np(&before);
  pthread_attr_destroy(&before);
  pthread_attr_destroy(&after);
}

}  // namespace
}  // namespace haptics::realtime_tests
