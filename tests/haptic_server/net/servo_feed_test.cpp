#include "haptic_server/net/servo_feed.h"

#include <gtest/gtest.h>

#include <deque>
#include <utility>
#include <vector>

namespace haptics::servo_feed_test {
namespace {

template <class Host>
class Samples : public Host {
 public:
  void feel(std::uint64_t tick, std::uint64_t revision, std::uint64_t adoptionTick) {
    samples_.emplace_back();
    samples_.back().tick = tick;
    samples_.back().sceneRevision = revision;
    samples_.back().adoptionTick = adoptionTick;
  }
  bool popTelemetry(TelemetrySample& sample) override {
    if (samples_.empty()) return false;
    sample = samples_.front();
    samples_.pop_front();
    return true;
  }

 private:
  std::deque<TelemetrySample> samples_;
};

class Hands : public Samples<ServerHost> {
 public:
  HandHost* secondHand() override { return &second; }
  Samples<HandHost> second;
};

TEST(ServoFeed, TellsOfARevisionOnceBothHandsHaveAdoptedIt) {
  Hands hands;
  ServoFeed feed(hands);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> adopted;
  const auto drain = [&] {
    EXPECT_TRUE(feed.drain([&](std::uint64_t revision, std::uint64_t tick) { adopted.emplace_back(revision, tick); }));
  };
  hands.feel(10, 1, 4);
  hands.second.feel(10, 1, 6);
  drain();
  EXPECT_EQ(adopted, (std::vector<std::pair<std::uint64_t, std::uint64_t>>{{1, 6}}));
  hands.feel(11, 2, 11);
  hands.second.feel(11, 1, 6);  // it lets go of what it presses
  drain();
  EXPECT_EQ(adopted.size(), 1U);
  hands.feel(12, 2, 11);
  hands.second.feel(12, 2, 12);
  drain();
  EXPECT_EQ(adopted.back(), (std::pair<std::uint64_t, std::uint64_t>{2, 12}));
}

}  // namespace
}  // namespace haptics::servo_feed_test
