#include <cstdio>
#include <future>
#include <iostream>
#include <memory>

#include "common/json/message_json.h"
#include "common/telemetry/fault_words.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

constexpr double kMicrosecondsPerNanosecond = 1e-3;
constexpr double kMillijoulesPerJoule = 1e3;

const char* yesNo(bool value) { return value ? "yes" : "no"; }

void printLatency(const char* name, const v1::LatencySummary& ns) {
  std::printf("%-10s p50 %.1f  p99 %.1f  p99.9 %.1f  max %.1f us\n", name, ns.p50() * kMicrosecondsPerNanosecond,
              ns.p99() * kMicrosecondsPerNanosecond, ns.p999() * kMicrosecondsPerNanosecond,
              ns.max() * kMicrosecondsPerNanosecond);
}

[[nodiscard]] std::string objectInWords(std::uint64_t id, const SceneVersion& scene) {
  const auto object = scene.find(id);
  return object ? object->name : "object " + std::to_string(id);
}

/// What the objects gave the hand, one a line.
void printEnergy(const v1::Status& status, const SceneVersion& scene) {
  std::uint64_t last = 0;
  for (const v1::FeatureEnergy& message : status.energy()) {
    const auto source = fromWire(message);
    if (!source) continue;
    if (last == 0) std::printf("energy     given to the hand, mJ:");
    if (source->object != last) std::printf("\n  %s", objectInWords(source->object, scene).c_str());
    std::printf("  %s %+.3g", nameOf(source->feature), source->given_J * kMillijoulesPerJoule);
    last = source->object;
  }
  if (last != 0) std::printf("\n");
}

void printExchange(const v1::DeviceExchange& exchange) {
  const auto count = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
  std::printf(
      "exchange   %llu commands, %llu replies, %llu used, %llu garbled packets; brought up %llu times, %llu faults\n",
      count(exchange.commands()), count(exchange.replies()), count(exchange.replies_used()),
      count(exchange.garbled_packets()), count(exchange.connections()), count(exchange.faults()));
}

void printSecondHand(const v1::HandStatus& hand) {
  std::printf("2nd hand   %s, at most %.2f N, fault: %s, %llu since start\n", printable(hand.device()).c_str(),
              hand.max_force_n(),
              faultInWords(static_cast<Fault>(hand.fault()), static_cast<DeviceFault>(hand.device_fault())),
              static_cast<unsigned long long>(hand.faults()));
  if (!hand.hand_leader().empty()) std::printf("           led by %s\n", printable(hand.hand_leader()).c_str());
  if (hand.has_device_exchange()) printExchange(hand.device_exchange());
}

void printForPeople(const v1::Status& status, const SceneVersion& scene) {
  const auto count = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
  const double share = status.ticks() > 0
                           ? 100.0 * static_cast<double>(status.contact_ticks()) / static_cast<double>(status.ticks())
                           : 0;
  std::printf("device     %s\n", printable(status.device()).c_str());
  if (!status.hand_leader().empty()) std::printf("hand       led by %s\n", printable(status.hand_leader()).c_str());
  if (status.has_device_exchange()) printExchange(status.device_exchange());
  if (status.has_played_recording()) {
    const v1::PlayedRecording& played = status.played_recording();
    std::printf("played     %llu ticks%s; %llu forces are not the recorded ones\n", count(played.ticks()),
                played.to_its_end() ? ", to its end" : "", count(played.differing_ticks()));
  }
  if (status.has_replay_check()) {
    const v1::ReplayCheck& check = status.replay_check();
    std::printf("replayed   %llu ticks, %llu skipped; %llu differences\n", count(check.ticks()),
                count(check.skipped_ticks()), count(check.differences()));
    if (check.differences() > 0) std::printf("           first: %s\n", printable(check.first_difference()).c_str());
  }
  if (status.has_second_hand()) printSecondHand(status.second_hand());
  std::printf("up         %.1f s, epoch %016llx, %u client%s\n", status.uptime_s(), count(status.epoch()),
              status.clients(), status.clients() == 1 ? "" : "s");
  std::printf("servo      %.0f Hz, %llu ticks, %llu missed\n", status.servo_rate_hz(), count(status.ticks()),
              count(status.missed_ticks()));
  printLatency("tick", status.tick_ns());
  printLatency("wake-up", status.wake_latency_ns());
  std::printf("real time  fifo %s, memory locked %s, pinned %s, %llu allocations\n", yesNo(status.fifo()),
              yesNo(status.memory_locked()), yesNo(status.pinned()), count(status.allocations_in_servo()));
  std::printf("fault      %s%s, %llu since start\n",
              faultInWords(static_cast<Fault>(status.fault()), static_cast<DeviceFault>(status.device_fault())),
              waitInWords(status.wait_s()).c_str(), count(status.faults()));
  if (status.has_watchdog()) {
    std::printf("watchdog   %s; started %llu times\n",
                status.watchdog().alive() ? "watches" : "MISSING: nobody takes the force away should the server hang",
                count(status.watchdog().started()));
  }
  if (status.depenetrated() > 0) {
    std::printf("inside     %llu times that the IHIP was depenetrated, the last time from %s\n",
                count(status.depenetrated()), objectInWords(status.depenetrated_from(), scene).c_str());
  }
  if (status.allowance_spent() > 0) {
    std::printf(
        "allowance  spent in %llu ticks, which left a part of the HIP's path, or bodies that collide, to the next: the "
        "scene is "
        "dense there\n",
        count(status.allowance_spent()));
  }
  std::printf("contact    %.1f %% of ticks, at most %.2f N\n", share, status.max_force_n());
  std::printf("scene      revision %llu, adopted %llu\n", count(status.revision()), count(status.adopted_revision()));
  std::printf("kept       %s\n", status.durable() ? "on the server's disk" : "until the server ends");
  for (const std::string& object : status.lost()) std::printf("lost       %s\n", printable(object).c_str());
  std::printf("root       %s\n", ContentHash::fromBytes(status.root()).value_or(ContentHash{}).hex().c_str());
  std::printf("dropped    %llu samples, %llu connections refused, %llu forged datagrams\n",
              count(status.dropped_samples()), count(status.refused_connections()), count(status.forged_datagrams()));
  printEnergy(status, scene);
}

}  // namespace

int status(const CommonOptions& common) {
  Connection connection(common, {});
  const auto view = connection.open();
  if (!view) return fail(kNoConnection, view.error());
  const auto promise = std::make_shared<std::promise<v1::Status>>();
  connection.link().requestStatus([promise](const v1::Status& status) { promise->set_value(status); });
  const auto answer = connection.await(promise->get_future());
  if (!answer) return fail(kNoConnection, answer.error());
  if (common.json) {
    std::cout << toJson(*answer).line() << '\n';
  } else {
    printForPeople(*answer, *(*view)->scene);
  }
  return kDone;
}

}  // namespace haptics
