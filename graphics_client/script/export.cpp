#include <algorithm>
#include <chrono>
#include <cstdio>
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

/// Hands the ticks of a running server to a sink.
class LiveTicks {
 public:
  LiveTicks(Connection& connection, SessionSink& sink) : connection_(connection), sink_(sink) {}

  [[nodiscard]] Result<void> add(const TickQueue::Tick& tick) {
    const TelemetrySample sample = fromWire(tick.sample);
    if (const auto gap = gaps_.next(sample.tick, sample.missedTicks)) {
      if (auto written = sink_.gap(*gap); !written) return written;
    }
    if (ticks_ == 0 || sample.sceneRevision > revision_) {
      if (auto written = addScene(sample); !written) return written;
    }
    const auto second = secondHandFromWire(tick.sample);
    const std::vector<BodyState> moved = bodiesFromWire(tick.sample);
    const bool dentsChanged = tick.tellsAll && takeDents(tick.sample);
    if (const auto tool = toolFromWire(tick.sample); tool || tick.tellsAll) tool_ = tool.value_or(ToolState{});
    ++ticks_;
    return sink_.add({sample, second ? &*second : nullptr, tool_, moved, dentsChanged ? &dents_ : nullptr});
  }

  [[nodiscard]] SessionEnd end() const { return {ticks_, gaps_.missed(), gaps_.lost(), {}}; }

 private:
  Connection& connection_;
  SessionSink& sink_;
  TickGaps gaps_;
  std::uint64_t ticks_ = 0, revision_ = 0;
  ToolState tool_;
  MotionState dents_;

  /// What this client holds by now may be a later revision than the tick's, never an earlier one.
  [[nodiscard]] Result<void> addScene(const TelemetrySample& sample) {
    const auto holds = [&](const MirrorView& v) {
      return v.scene->revision() >= sample.sceneRevision &&
             std::ranges::all_of(v.scene->objects(), [&](const auto& object) { return v.isComplete(*object); });
    };
    const auto view = connection_.link().waitUntil(holds, connection_.timeout());
    if (!view) return connection_.noConnection(*connection_.link().latest());
    revision_ = view->scene->revision();
    return sink_.scene(sample.tick, *view);
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
  LiveTicks ticks(connection, file->sink());
  const auto began = Clock::now();
  double elapsed_s = 0;
  while (elapsed_s < options.duration_s && !Interrupt::interrupted()) {
    const auto taken = queue.take(std::chrono::milliseconds(100));
    for (const TickQueue::Tick& tick : taken) {
      if (auto written = ticks.add(tick); !written) return tl::unexpected(std::move(written).error());
    }
    const auto latest = connection.link().latest();
    if (taken.empty() && latest->link == LinkState::kRefused) return connection.noConnection(*latest);
    elapsed_s = std::chrono::duration<double>(Clock::now() - began).count();
    showProgress("exporting", elapsed_s / options.duration_s, std::to_string(ticks.end().ticks) + " ticks");
  }
  endProgress();
  const SessionEnd end = ticks.end();
  if (end.ticks == 0) return refused("--live", "no tick has come from " + common.server.text());
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
    return fail(options.live && end.error().field.starts_with("--connect") ? kNoConnection : kRefused, end.error());
  }
  print(common, options.out, *end);
  return kDone;
}

}  // namespace haptics
