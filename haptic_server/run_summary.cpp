#include "haptic_server/run_summary.h"

#include <fstream>

#include "common/json/message_json.h"
#include "common/telemetry/body_json.h"
#include "haptic_server/servo/allocation_tripwire.h"

namespace haptics {
namespace {

void fillLatency(const LatencyHistogram& histogram, v1::LatencySummary& summary) {
  summary.set_p50(static_cast<double>(histogram.quantile_ns(0.5)));
  summary.set_p99(static_cast<double>(histogram.quantile_ns(0.99)));
  summary.set_p999(static_cast<double>(histogram.quantile_ns(0.999)));
  summary.set_max(static_cast<double>(histogram.max_ns()));
}

[[nodiscard]] Json bodiesOf(const MotionState& motion) {
  Json bodies = Json::array();
  for (const BodyState& body : motion.bodies()) bodies.push(bodyJson(body));
  return bodies;
}

}  // namespace

void fillHandStatus(const HandStatistics& hand, v1::HandStatus& status) {
  status.set_contact_ticks(hand.contactTicks.load());
  status.set_max_force_n(hand.maxForce_N.load());
  status.set_fault(static_cast<v1::Fault>(hand.fault.load()));
  status.set_device_fault(static_cast<v1::DeviceFault>(hand.deviceFault.load()));
  status.set_faults(hand.faults.load());
  status.set_depenetrated(hand.depenetrated.load());
  status.set_allowance_spent(hand.allowanceSpent.load());
  status.set_dropped_samples(hand.droppedSamples.load());
}

void fillReplayCheck(const ReplayCheck::Count& count, v1::ReplayCheck& status) {
  status.set_ticks(count.ticks);
  status.set_skipped_ticks(count.skipped);
  status.set_differences(count.differences);
  status.set_first_difference(count.first);
}

void fillServoStatus(const ServoStatistics& servo, const HandStatistics& hand, const RealtimeStatus& realtime,
                     v1::Status& status) {
  status.set_ticks(servo.ticks.load());
  status.set_missed_ticks(servo.missedTicks.load());
  status.set_depenetrated(hand.depenetrated.load());
  status.set_depenetrated_from(hand.depenetratedFrom.load());
  status.set_allowance_spent(hand.allowanceSpent.load());
  status.set_wait_s(hand.wait_s.load());
  status.set_contact_ticks(hand.contactTicks.load());
  status.set_max_force_n(hand.maxForce_N.load());
  status.set_adopted_revision(servo.adoptedRevision.load());
  status.set_dropped_samples(hand.droppedSamples.load());
  status.set_servo_rate_hz(servo.rate_Hz.load());
  status.set_allocations_in_servo(AllocationTripwire::count());
  status.set_fault(static_cast<v1::Fault>(hand.fault.load()));
  status.set_device_fault(static_cast<v1::DeviceFault>(hand.deviceFault.load()));
  status.set_faults(hand.faults.load());
  fillLatency(servo.tick_ns, *status.mutable_tick_ns());
  fillLatency(servo.wakeLatency_ns, *status.mutable_wake_latency_ns());
  status.set_fifo(realtime.fifo);
  status.set_memory_locked(realtime.memoryLocked);
  status.set_pinned(realtime.pinned);
}

Result<void> writeSummary(const std::string& file, const v1::Status& status, double maxForceLimit_N,
                          const MotionState& motion, const ContentHash& deformed) {
  Json summary = {
      {"ticks", status.ticks()},
      {"missed_ticks", status.missed_ticks()},
      {"rate_hz", status.servo_rate_hz()},
      {"uptime_s", status.uptime_s()},
      {"tick_ns", toJson(status.tick_ns())},
      {"wake_latency_ns", toJson(status.wake_latency_ns())},
      {"contact_ticks", status.contact_ticks()},
      {"depenetrated", status.depenetrated()},
      {"allowance_spent", status.allowance_spent()},
      {"max_force_N", status.max_force_n()},
      {"force_limit_N", maxForceLimit_N},
      {"allocations_in_servo", status.allocations_in_servo()},
      {"faults", status.faults()},
      {"dropped_samples", status.dropped_samples()},
      {"refused_connections", status.refused_connections()},
      {"scene_revision", status.revision()},
      {"adopted_revision", status.adopted_revision()},
      {"scene_hash", ContentHash::fromBytes(status.root()).value_or(ContentHash{}).hex()},
      {"device", status.device()},
      {"bodies", bodiesOf(motion)},
      {"dents", motion.dentCount},
      {"deformed_hash", deformed.hex()},
      {"realtime", {{"fifo", status.fifo()}, {"memory_locked", status.memory_locked()}, {"pinned", status.pinned()}}},
  };
  if (status.has_second_hand()) {
    const v1::HandStatus& second = status.second_hand();
    Json hand = {{"device", second.device()},
                 {"contact_ticks", second.contact_ticks()},
                 {"depenetrated", second.depenetrated()},
                 {"allowance_spent", second.allowance_spent()},
                 {"max_force_N", second.max_force_n()},
                 {"faults", second.faults()},
                 {"dropped_samples", second.dropped_samples()}};
    if (second.has_device_exchange()) hand.set("device_exchange", toJson(second.device_exchange()));
    summary.set("second_hand", hand);
  }
  if (status.has_device_exchange()) summary.set("device_exchange", toJson(status.device_exchange()));
  if (status.has_watchdog()) summary.set("watchdog", toJson(status.watchdog()));
  if (status.has_played_recording()) summary.set("played_recording", toJson(status.played_recording()));
  if (status.has_replay_check()) summary.set("replay_check", toJson(status.replay_check()));
  std::ofstream out(file);
  out << summary.indented() << '\n';
  out.close();
  if (!out) return refused(file, "the summary could not be written; the folder should exist and be writable");
  return {};
}

}  // namespace haptics
