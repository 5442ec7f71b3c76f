#include "tests/stress/auditor.h"

#include "common/clock/monotonic.h"
#include "common/wire/convert.h"

namespace haptics::stress {
namespace {

constexpr double kPulses_Hz = 200;

}  // namespace

Auditor::Auditor(Endpoint server, std::function<std::uint64_t()> life) : life_(std::move(life)) {
  link_ = std::make_unique<ServerLink>(
      ServerLink::Options{.server = server,
                          .clientName = "auditor",
                          .telemetryRate_Hz = kPulses_Hz,
                          .connect = tappedTcp(server, [this](const v1::Envelope& envelope) { take(envelope); })});
}

void Auditor::take(const v1::Envelope& envelope) {
  const std::uint64_t now_ns = monotonicNow_ns();
  const std::lock_guard lock(mutex_);
  if (!order_.follows(envelope)) ++gaps_;
  if (envelope.has_telemetry()) {
    const v1::Telemetry& sample = envelope.telemetry();
    pulses_.push_back({now_ns, sample.tick(), sample.missed_ticks(), life_(), sample.time_ns()});
  }
  if (!envelope.has_commit()) return;
  const auto commit = fromWire(envelope.commit());
  if (!commit) return;
  Commit seen{now_ns, commit->revision, commit->root, {}, std::nullopt};
  for (const ObjectRecord& record : commit->put) {
    if (record.name == kCounter) seen.counter = countOf(record);
    if (record.name.starts_with("mark")) seen.marks.emplace_back(record.name, editNameOf(record));
  }
  commits_.push_back(std::move(seen));
}

std::vector<Auditor::Commit> Auditor::commits() const {
  const std::lock_guard lock(mutex_);
  return commits_;
}
std::vector<Auditor::Pulse> Auditor::pulses() const {
  const std::lock_guard lock(mutex_);
  return pulses_;
}
std::uint64_t Auditor::gaps() const {
  const std::lock_guard lock(mutex_);
  return gaps_;
}

}  // namespace haptics::stress
