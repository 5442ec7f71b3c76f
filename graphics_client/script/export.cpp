#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/json/message_json.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "graphics_client/mirror/tick_queue.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/progress_bar.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kNews{100};  // whether there is news

bool isLive(const MirrorView& view) { return view.link == LinkState::kLive; }

/// Hands the ticks of a running server to a sink.
class LiveTicks {
 public:
  LiveTicks(Connection& connection, SessionSink& sink, double duration_s)
      : connection_(connection), sink_(sink), epoch_(connection.link().latest()->epoch), duration_s_(duration_s) {}

  [[nodiscard]] double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }
  [[nodiscard]] bool isGoingOn() const { return why_.empty() && !Interrupt::interrupted(); }
  [[nodiscard]] bool isOver() const { return !isGoingOn() || elapsed_s() >= duration_s_; }

  /// False: what came before is all that can be written, and the end says why.
  [[nodiscard]] Result<bool> add(const TickQueue::Tick& tick) {
    const TelemetrySample sample = fromWire(tick.sample);
    if (ticks_ > 0 && sample.tick <= tick_) return endWith("the server restarted");
    if (const auto gap = gaps_.next(sample.tick, sample.missedTicks)) {
      if (auto written = sink_.gap(*gap); !written) return tl::unexpected(std::move(written).error());
    }
    if (ticks_ == 0 || sample.sceneRevision > revision_) {
      if (auto added = addScene(sample); !added || !*added) return added;
    }
    const auto second = secondHandFromWire(tick.sample);
    const std::vector<BodyState> moved = bodiesFromWire(tick.sample);
    const bool dentsChanged = tick.tellsAll && takeDents(tick.sample);
    if (const auto tool = toolFromWire(tick.sample); tool || tick.tellsAll) tool_ = tool.value_or(ToolState{});
    ++ticks_;
    tick_ = sample.tick;
    return sink_.add({sample, second ? &*second : nullptr, tool_, moved, dentsChanged ? &dents_ : nullptr}).map([] {
      return true;
    });
  }
  /// After the last tick nothing is known any more. False, so that add() can return it.
  bool endWith(std::string why) {
    why_ = std::move(why);
    return false;
  }
  [[nodiscard]] const std::string& why() const { return why_; }

  [[nodiscard]] SessionEnd end() const {
    return {ticks_, gaps_.missed(), gaps_.lost(),
            why_.empty() ? why_ : why_ + "; it ends after tick " + std::to_string(tick_)};
  }

 private:
  Connection& connection_;
  SessionSink& sink_;
  const std::uint64_t epoch_;
  const double duration_s_;
  const Clock::time_point began_ = Clock::now();
  TickGaps gaps_;
  std::uint64_t ticks_ = 0, revision_ = 0, tick_ = 0;
  std::string why_;
  ToolState tool_;
  MotionState dents_;

  /// What this client holds by now may be a later revision than the tick's, never an earlier one. Meshes take their time to
  /// come: they are waited for as long as they keep arriving.
  [[nodiscard]] Result<bool> addScene(const TelemetrySample& sample) {
    const auto holds = [&](const MirrorView& v) {
      return v.epoch == epoch_ && v.scene->revision() >= sample.sceneRevision &&
             std::ranges::all_of(v.scene->objects(), [&](const auto& object) { return v.isComplete(*object); });
    };
    const ServerLink& link = connection_.link();
    auto view = link.waitUntil(holds, kNews);
    auto known = link.latest();
    for (auto moved = Clock::now(); !view && !isOver(); view = link.waitUntil(holds, kNews)) {
      const auto latest = link.latest();
      if (latest->epoch != epoch_) return endWith("the server restarted");
      const auto state = [](const MirrorView& v) { return std::tuple(isLive(v), v.scene->revision(), v.assetBytes); };
      if (state(*latest) != state(*known)) moved = Clock::now();
      known = latest;
      if (Clock::now() - moved > connection_.timeout()) break;
    }
    if (!view && Interrupt::interrupted()) return endWith("interrupted");
    if (!view) return endWith("revision " + std::to_string(sample.sceneRevision) + " of the scene has not come whole");
    revision_ = view->scene->revision();
    return sink_.scene(sample.tick, *view).map([] { return true; });
  }

  [[nodiscard]] bool takeDents(const v1::Telemetry& message) {
    const std::vector<ObjectDent> dents = dentsFromWire(message);
    if (std::ranges::equal(dents, dents_.dents())) return false;
    dents_.dentCount = std::min(dents.size(), dents_.dent.size());
    std::copy_n(dents.begin(), dents_.dentCount, dents_.dent.begin());
    return true;
  }
};

[[nodiscard]] Result<SessionEnd> exportLive(const CommonOptions& common, const ExportOptions& options) {
  TickQueue queue;
  Connection connection(common, {.meshes = true, .onTicks = [&queue](const v1::TelemetryBatch& b) { queue.put(b); }});
  const auto view = connection.open();
  if (!view) return tl::unexpected(view.error());
  const SessionFacts facts{.source = common.server.text(),
                           .server = (*view)->serverName,
                           .device = (*view)->device,
                           .secondDevice = (*view)->secondDevice,
                           .rate_Hz = (*view)->servoRate_Hz,
                           .maxForce_N = (*view)->maxForce_N,
                           .began_unix_ns = std::chrono::system_clock::now().time_since_epoch().count()};
  auto file = ExportFile::open(options.out, options.format, facts);
  if (!file) return tl::unexpected(std::move(file).error());
  LiveTicks ticks(connection, file->sink(), options.duration_s);
  auto heard = Clock::now();
  // Where the link is down when the time is over, the first tick after that names the ones that are lost.
  for (bool isDown = false; isDown ? ticks.isGoingOn() : !ticks.isOver();) {
    const auto taken = queue.take(kNews);
    for (const TickQueue::Tick& tick : taken) {
      const auto added = ticks.add(tick);
      if (!added) return tl::unexpected(added.error());
      if (!*added) break;
    }
    const auto latest = connection.link().latest();
    isDown = taken.empty() && !isLive(*latest);
    if (!isDown) heard = Clock::now();
    const bool isGone = latest->link == LinkState::kRefused || Clock::now() - heard > connection.timeout();
    if (taken.empty() && isGone) ticks.endWith(connection.noConnection(*latest).value().text());
    showProgress("exporting", std::min(1.0, ticks.elapsed_s() / options.duration_s),
                 std::to_string(ticks.end().ticks) + " ticks");
  }
  endProgress();
  if (ticks.why().empty() && Interrupt::interrupted()) ticks.endWith("interrupted");
  const auto last = connection.link().latest();
  const SessionEnd end = ticks.end();
  if (end.ticks == 0 && !isLive(*last)) return connection.noConnection(*last);
  if (end.ticks == 0) {
    return refused("--live", ticks.why().empty() ? "no tick has come from " + common.server.text() : ticks.why());
  }
  if (auto finished = file->finish(end); !finished) return tl::unexpected(std::move(finished).error());
  return end;
}

[[nodiscard]] Result<SessionEnd> exportRecorded(const ExportOptions& options) {
  auto end = exportRecording(options.recording, options.out, options.format, [](double share) {
    showProgress("exporting", share);
    return !Interrupt::interrupted();
  });
  endProgress();
  return end;
}

void print(const CommonOptions& common, const std::filesystem::path& out, const SessionEnd& end) {
  if (common.json) {
    const Json said{{"file", out.string()},
                    {"ticks", end.ticks},
                    {"missed_by_servo", end.missed},
                    {"lost", end.lost},
                    {"note", end.note}};
    std::puts(said.line().c_str());
    return;
  }
  std::printf("%s: %llu ticks; %llu missed by the servo, %llu lost\n", printable(out.string()).c_str(),
              static_cast<unsigned long long>(end.ticks), static_cast<unsigned long long>(end.missed),
              static_cast<unsigned long long>(end.lost));
  if (!end.note.empty()) std::printf("note: %s\n", end.note.c_str());
}

}  // namespace

int exportSession(const CommonOptions& common, const ExportOptions& options) {
  const Interrupt interrupt;
  const auto end = options.live ? exportLive(common, options) : exportRecorded(options);
  if (!end) {
    if (Interrupt::interrupted()) return kInterrupted;
    return fail(codeOf(end.error()), end.error());
  }
  print(common, options.out, *end);
  return options.live && !end->note.empty() && !Interrupt::interrupted() ? kNoConnection : kDone;
}

}  // namespace haptics
