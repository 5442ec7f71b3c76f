#include "tests/stress/client.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <mutex>
#include <thread>

#include "common/clock/monotonic.h"
#include "graphics_client/mirror/server_link.h"
#include "tests/stress/journal.h"
#include "tests/stress/stress_scene.h"
#include "tests/stress/tapped_tcp.h"

namespace haptics::stress {
namespace {

constexpr double kTelemetry_Hz = 60;
constexpr std::chrono::milliseconds kClientLook{20};
constexpr int kMaxUnanswered = 64;  // a dead line must not pile up edits for ever

std::atomic<bool> stopRequested{false};

/// Submits edits, at most one increment at a time, and writes down what becomes of them.
class Editor {
 public:
  Editor(ServerLink& link, const Journal& journal, int client, std::uint64_t life)
      : link_(link), journal_(journal), client_(client), life_(life) {}

  void edit() {
    if (unanswered_ >= kMaxUnanswered) return;
    const auto counter = incrementing_ ? nullptr : knownCounter();
    const EditName name{life_, ++lastNumber_};
    const std::uint64_t value = counter ? countOf(*counter) + 1 : 0;
    write(Record::Kind::kSubmitted, name.number, 0, value);
    ++unanswered_;
    if (counter) incrementing_ = true;
    link_.submit(
        makeEdit(client_, name, counter.get()),
        {[this, number = name.number, value](const v1::EditReply& reply) { replied(number, value, reply); }, {}});
  }

 private:
  /// As the last conflict told it, or as the mirror has it: whichever is newer.
  [[nodiscard]] std::shared_ptr<const ObjectRecord> knownCounter() {
    auto mirrored = link_.latest()->scene->find(kCounter);
    const std::lock_guard lock(mutex_);
    return told_ && (!mirrored || told_->revision > mirrored->revision) ? told_ : mirrored;
  }

  /// On the link's thread.
  void replied(std::uint64_t number, std::uint64_t value, const v1::EditReply& reply) {
    if (reply.has_accepted()) {
      write(Record::Kind::kAccepted, number, reply.accepted().revision(), value);
      remember(reply.accepted().object());
    } else if (reply.has_conflict()) {
      write(Record::Kind::kConflict, number, 0, value);
      remember(reply.conflict().current());
    } else {
      write(Record::Kind::kRejected, number, 0, value);
      std::fprintf(stderr, "client %d: edit %llu rejected: %s %s\n", client_, static_cast<unsigned long long>(number),
                   reply.rejected().field().c_str(), reply.rejected().reason().c_str());
    }
    --unanswered_;
    if (value > 0) incrementing_ = false;
  }

  template <class States>
  void remember(const States& states) {
    for (const v1::ObjectState& state : states) {
      if (state.name() != kCounter) continue;
      auto counter = std::make_shared<ObjectRecord>();
      counter->id = state.id();
      counter->revision = state.revision();
      counter->pose.position.x = state.pose().position().x();
      const std::lock_guard lock(mutex_);
      told_ = std::move(counter);
    }
  }

  void write(Record::Kind kind, std::uint64_t number, std::uint64_t revision, std::uint64_t value) const {
    journal_.write(
        {.time_ns = monotonicNow_ns(), .kind = kind, .number = number, .revision = revision, .value = value});
  }

  ServerLink& link_;
  const Journal& journal_;
  int client_;
  std::uint64_t life_;
  std::uint64_t lastNumber_ = 0;
  std::atomic<int> unanswered_{0};
  std::atomic<bool> incrementing_{false};
  std::mutex mutex_;  // guards told_
  std::shared_ptr<const ObjectRecord> told_;
};

/// Writes down what the client holds, as a viewer would show it.
class Observer {
 public:
  explicit Observer(const Journal& journal) : journal_(journal) {}

  void look(const MirrorView& view) {
    const std::uint64_t now_ns = monotonicNow_ns();
    if (view.connections != connections_) {
      connections_ = view.connections;
      samplesBefore_ = view.samplesReceived;
      journal_.write({.time_ns = now_ns,
                      .kind = Record::Kind::kLink,
                      .number = view.connections,
                      .revision = view.stateResets,
                      .value = view.resyncs});
    }
    Record record{.time_ns = now_ns, .kind = Record::Kind::kView, .revision = view.scene->revision()};
    record.root = view.scene->root();
    if (view.hashesEqual) record.flags |= Record::kEqual;
    if (view.telemetryByDatagram) record.flags |= Record::kByDatagram;
    if (view.link == LinkState::kLive) record.flags |= Record::kLive;
    // A sample from before the present connection says how long that was down, not how long samples travel.
    if (view.link == LinkState::kLive && view.sample && view.samplesReceived > samplesBefore_) {
      record.flags |= Record::kAgeKnown;
      record.age_ns = static_cast<std::int64_t>(now_ns - view.sample->time_ns);
      if (view.clockUncertainty_s > 0) {
        record.ageByClient_ns = static_cast<std::int64_t>(view.telemetryAgeAt_s(now_ns) * 1e9);
      }
    }
    journal_.write(record);
  }

 private:
  const Journal& journal_;
  std::uint64_t connections_ = 0, samplesBefore_ = 0;
};

}  // namespace

void runClient(const RunPlan& plan, const ClientOptions& options) {
  std::signal(SIGTERM, [](int) { stopRequested = true; });
  const Journal journal(options.journal);
  CommitOrder order;
  auto link = std::make_unique<ServerLink>(ServerLink::Options{
      .server = options.server,
      .clientName = "stress " + std::to_string(options.number),
      .telemetryRate_Hz = kTelemetry_Hz,
      .datagrams = options.datagrams,
      .connect = tappedTcp(options.server, [&](const v1::Envelope& envelope) {
        if (order.follows(envelope)) return;
        journal.write(
            {.time_ns = monotonicNow_ns(), .kind = Record::Kind::kGap, .revision = envelope.commit().revision()});
      })});
  Editor editor(*link, journal, options.number, options.life);
  Observer observer(journal);
  const auto editPeriod_ns = static_cast<std::uint64_t>(1e9 / plan.edits_Hz);
  std::uint64_t nextEdit_ns = 0;
  while (!stopRequested) {
    const auto view = link->latest();
    observer.look(*view);
    const std::uint64_t now_ns = monotonicNow_ns();
    if (options.edits && plan.attackAt(now_ns) && view->link == LinkState::kLive && now_ns >= nextEdit_ns) {
      nextEdit_ns = std::max(nextEdit_ns + editPeriod_ns, now_ns - editPeriod_ns);
      editor.edit();
    }
    std::this_thread::sleep_for(kClientLook);
  }
  const auto view = link->latest();
  const auto root = recomputedRoot(*view);
  link.reset();  // no answer comes any more
  journal.write({.time_ns = monotonicNow_ns(),
                 .kind = Record::Kind::kFinal,
                 .flags = view->hashesEqual ? Record::kEqual : 0U,
                 .number = view->connections,
                 .revision = view->scene->revision(),
                 .value = view->resyncs,
                 .root = root.value_or(ContentHash{})});
}

}  // namespace haptics::stress
