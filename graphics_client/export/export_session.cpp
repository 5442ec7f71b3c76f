#include "graphics_client/export/export_session.h"

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "common/text/printable.h"
#include "graphics_client/export/csv_sink.h"
#include "graphics_client/export/hdf5_sink.h"
#include "graphics_client/export/mcap_sink.h"
#include "graphics_client/session/replay_mirror.h"
#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/recording/recording_reader.h"
#include "haptic_server/recording/replay.h"

namespace haptics {
namespace {

[[nodiscard]] Result<std::unique_ptr<SessionSink>> makeSink(const std::filesystem::path& file, ExportFormat format,
                                                            const SessionFacts& facts) {
  switch (format) {
    case ExportFormat::kHdf5:
      return makeHdf5Sink(file, facts);
    case ExportFormat::kCsv:
      return makeCsvSink(file, facts);
    case ExportFormat::kMcap:
      break;
  }
  return makeMcapSink(file, facts);
}

[[nodiscard]] SessionFacts factsOf(const std::filesystem::path& recording, const RecordingFacts& facts) {
  return {.source = recording.filename().string(),
          .server = facts.server,
          .device = facts.device,
          .secondDevice = facts.secondHand ? facts.secondHand->device : "",
          .rate_Hz = facts.rate_Hz,
          .maxForce_N = facts.config.maxForce_N,
          .began_unix_ns = facts.began_unix_ns};
}

/// Hands a replay's ticks to a sink.
class ReplayedTicks {
 public:
  ReplayedTicks(SessionSink& sink, const ExportProgress& progress) : sink_(sink), progress_(progress) {}

  bool take(const ReplayedTick& tick) {
    const auto written = write(tick);
    if (!written) failure_ = written.error();
    return written.has_value();
  }

  [[nodiscard]] const std::optional<Error>& failure() const noexcept { return failure_; }
  [[nodiscard]] SessionEnd end() const { return {ticks_, gaps_.missed(), gaps_.lost(), {}}; }

 private:
  SessionSink& sink_;
  const ExportProgress& progress_;
  ReplayMirror mirror_{1};
  TickGaps gaps_;
  std::uint64_t ticks_ = 0, missed_ = 0;
  std::uint64_t revision_ = 0;  // of the scene: the servo may be given one again, with what it made of it
  std::optional<std::uint64_t> last_;
  MotionState motion_;
  std::vector<BodyState> moved_;
  std::optional<Error> failure_;

  [[nodiscard]] Result<void> write(const ReplayedTick& tick) {
    constexpr std::uint64_t kLookEvery = 1'000;  // ticks
    if (ticks_ % kLookEvery == 0 && !progress_(tick.share)) return refused("", "given up");
    const auto isNew = mirror_.follow(tick.scene);
    if (!isNew) return tl::unexpected(isNew.error());
    if (*isNew && (ticks_ == 0 || mirror_.view().scene->revision() != revision_)) {
      revision_ = mirror_.view().scene->revision();
      if (auto written = sink_.scene(tick.sample.tick, mirror_.view()); !written) return written;
    }
    // The servo that is replayed slept through what is missing: a recording holds every tick that was.
    TelemetrySample sample = tick.sample;
    if (last_) missed_ += sample.tick - *last_ - 1;
    last_ = sample.tick;
    sample.missedTicks = missed_;
    if (const auto gap = gaps_.next(sample.tick, missed_); gap) {
      if (auto written = sink_.gap(*gap); !written) return written;
    }
    const bool dentsChanged = tick.motion != nullptr && !std::ranges::equal(tick.motion->dents(), motion_.dents());
    findMoved(tick.motion);
    ++ticks_;
    return sink_.add({sample, tick.secondSample, motion_.tool, moved_, dentsChanged ? &motion_ : nullptr});
  }

  void findMoved(const MotionState* motion) {
    moved_.clear();
    if (motion == nullptr) return;
    for (const BodyState& body : motion->bodies()) {
      if (std::ranges::find(motion_.bodies(), body) == motion_.bodies().end()) moved_.push_back(body);
    }
    motion_ = *motion;
  }
};

[[nodiscard]] std::string noteOf(const ReplayOutcome& outcome) {
  std::string note;
  const auto add = [&](const std::string& words) { note += (note.empty() ? "" : "; ") + words; };
  if (outcome.refusal) add("the recording is read up to here: " + printable(outcome.refusal->text()));
  if (outcome.cutOff) add("the recording was cut off while it was being written");
  if (outcome.differing > 0)
    add(std::to_string(outcome.differing) + " ticks come to another force than was recorded, tick " +
        std::to_string(outcome.first ? outcome.first->tick : 0) + " first" +
        (outcome.sameStep ? "" : ": it was made by another version of the step"));
  return note;
}

}  // namespace

Result<ExportFile> ExportFile::open(const std::filesystem::path& file, ExportFormat format, const SessionFacts& facts) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return refused(file.string(), "is a folder; name a file in it");
  PendingFile pending(file);
  auto sink = makeSink(pending.place(), format, facts);
  if (!sink) return tl::unexpected(std::move(sink).error());
  return ExportFile(std::move(pending), *std::move(sink));
}

Result<void> ExportFile::finish(const SessionEnd& end) {
  if (auto finished = sink_->finish(end); !finished) return finished;
  sink_.reset();
  return pending_.finish();
}

Result<SessionEnd> exportRecording(const std::filesystem::path& recording, const std::filesystem::path& out,
                                   ExportFormat format, const ExportProgress& progress) {
  const auto within = [&](Error error) {
    return tl::unexpected(std::move(error).within(recording.string() + (error.field.empty() ? "" : ": ")));
  };
  const auto bytes = RecordingBytes::open(recording);
  if (!bytes) return within(bytes.error());
  const auto reader = RecordingReader::open(*bytes);
  if (!reader) return within(reader.error());
  auto file = ExportFile::open(out, format, factsOf(recording, reader->facts()));
  if (!file) return tl::unexpected(std::move(file).error());
  ReplayedTicks ticks(file->sink(), progress);
  const auto outcome = replay(*bytes, [&](const ReplayedTick& tick) { return ticks.take(tick); });
  if (!outcome) return within(outcome.error());
  if (ticks.failure()) return tl::unexpected(*ticks.failure());
  SessionEnd end = ticks.end();
  end.note = noteOf(*outcome);
  if (end.ticks == 0) return within({"", end.note.empty() ? "holds no tick" : end.note});
  if (auto finished = file->finish(end); !finished) return tl::unexpected(std::move(finished).error());
  return end;
}

}  // namespace haptics
