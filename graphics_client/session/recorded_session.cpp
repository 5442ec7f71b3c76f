#include "graphics_client/session/recorded_session.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/telemetry/fault_words.h"
#include "common/text/printable.h"
#include "graphics_client/session/replay_mirror.h"
#include "haptic_server/recording/recording_bytes.h"
#include "haptic_server/recording/recording_reader.h"

namespace haptics {
namespace {

/// Of an object in a scene, beside its assets, generously: scenes share records, but not what finds them.
constexpr std::size_t kObject_bytes = 512;

/// Scenes of each recording that is opened are others than any before.
std::uint64_t epochOfRecording() {
  static std::atomic<std::uint64_t> opened{0};
  return (std::uint64_t{1} << 63) + ++opened;
}

std::string seconds(double time_s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f s", time_s);
  return text;
}

}  // namespace

/// Takes a replay's ticks.
class RecordedSession::Reader {
 public:
  Reader(RecordedSession& session, const std::stop_token& stop, const std::function<void(double)>& progress)
      : session_(session), stop_(stop), progress_(progress) {}

  bool take(const ReplayedTick& tick) {
    if (stop_.stop_requested()) return false;
    if (progress_) progress_(tick.share);
    const TelemetrySample& sample = tick.sample;
    if (!first_) first_ = lastTick_ = sample.tick;
    if (sample.tick > lastTick_) missed_ += sample.tick - lastTick_ - 1;
    lastTick_ = sample.tick;
    const double time_s = static_cast<double>(sample.tick - *first_) * period_s_;
    if (!takeScene(tick.scene, time_s)) return false;
    if (tick.motion != nullptr) newest_ = *tick.motion;
    hasMotion_ = hasMotion_ || tick.motion != nullptr;
    motionIsNew_ = motionIsNew_ || tick.motion != nullptr;
    if (sample.fault != Fault::kNone && sample.fault != fault_) {
      mark({time_s, true, faultInWords(sample.fault, sample.device.fault)});
    }
    fault_ = sample.fault;
    const bool marked = sample.device.does(HandAction::kMark);
    if (marked && !marked_) mark({time_s, false, "marked by a button"});
    marked_ = marked;
    if (session_.moments_.wants(time_s)) keep(tick, time_s);
    return true;
  }

  void setPeriod(double period_s) { period_s_ = period_s; }

 private:
  RecordedSession& session_;
  const std::stop_token& stop_;
  const std::function<void(double)>& progress_;
  ReplayMirror mirror_{epochOfRecording()};
  std::optional<std::uint64_t> first_;
  std::uint64_t lastTick_ = 0, missed_ = 0;
  double period_s_ = 1e-3;
  std::size_t scenes_bytes_ = 0;
  Fault fault_ = Fault::kNone;
  bool marked_ = false;
  MotionState newest_;
  bool hasMotion_ = false, motionIsNew_ = false;
  std::shared_ptr<const RecordedMotion> motion_;

  void mark(Mark mark) {
    if (session_.marks_.size() < kMaxMarks) session_.marks_.push_back(std::move(mark));
  }

  /// False: it cannot be held.
  bool takeScene(const RemadeScene* remade, double time_s) {
    const bool isFirst = session_.scenes_.empty();
    const std::uint64_t revision = isFirst ? 0 : session_.scenes_.back()->scene->revision();
    auto isNew = mirror_.follow(remade);
    if (isNew && !*isNew) return true;
    MirrorView view = mirror_.view();
    scenes_bytes_ += mirror_.addedBytes() + kObject_bytes * view.scene->objects().size();
    if (isNew && scenes_bytes_ > kMaxScenes_bytes)
      isNew = refused("", "its scenes take more than " + std::to_string(kMaxScenes_bytes >> 20) + " MiB");
    if (!isNew) {
      session_.endedEarly_ = isNew.error().text();
      return false;
    }
    session_.scenes_.push_back(std::make_shared<const MirrorView>(std::move(view)));
    if (const std::uint64_t now = session_.scenes_.back()->scene->revision(); !isFirst && now != revision)
      mark({time_s, false, "edit: revision " + std::to_string(now)});
    return true;
  }

  void keep(const ReplayedTick& tick, double time_s) {
    if (hasMotion_ && std::exchange(motionIsNew_, false)) {
      const auto bodies = newest_.bodies();
      const auto dents = newest_.dents();
      motion_ = std::make_shared<const RecordedMotion>(
          RecordedMotion{{bodies.begin(), bodies.end()}, {dents.begin(), dents.end()}, newest_.tool});
    }
    RecordedMoment moment{time_s, tick.sample, motion_, session_.scenes_.size() - 1};
    if (tick.secondSample != nullptr) moment.secondHand = *tick.secondSample;
    moment.sample.missedTicks = missed_;
    moment.sample.servoRate_Hz = 1 / period_s_;
    constexpr double kMax_s = 9e9;  // of a damaged recording; more is no number of nanoseconds
    moment.sample.time_ns =
        static_cast<std::uint64_t>(std::llround(1e9 * std::min(time_s, kMax_s))) + 1;  // 0 says that there is none
    session_.moments_.add(std::move(moment));
  }
};

Result<RecordedSession> RecordedSession::read(const std::filesystem::path& file, const std::stop_token& stop,
                                              const std::function<void(double share)>& progress) {
  const auto within = [&](Error error) {
    return tl::unexpected(std::move(error).within(file.string() + (error.field.empty() ? "" : ": ")));
  };
  const auto bytes = RecordingBytes::open(file);
  if (!bytes) return within(bytes.error());
  const auto reader = RecordingReader::open(*bytes);
  if (!reader) return within(reader.error());
  RecordedSession session;
  session.name_ = printable(file.filename().string());
  Reader ticks(session, stop, progress);
  ticks.setPeriod(1 / reader->facts().rate_Hz);
  try {
    const Interruptible work(stop);
    auto outcome = replay(*bytes, [&](const ReplayedTick& tick) { return ticks.take(tick); });
    if (!outcome) return within(outcome.error());
    session.outcome_ = *std::move(outcome);
  } catch (const Interrupted&) {
  }
  if (stop.stop_requested()) return within({"", "cancelled"});
  if (!session.moments_.list().empty()) return session;
  const Error none{"", session.endedEarly_.empty() ? "holds no tick" : session.endedEarly_};
  return within(session.outcome_.refusal.value_or(none));
}

std::string RecordedSession::verdict() const {
  std::string words = "every force is the same bit for bit";
  if (outcome_.differing > 0) {
    words = std::to_string(outcome_.differing) + " of " + std::to_string(outcome_.ticks) + " forces differ";
    if (outcome_.first) words += ", tick " + std::to_string(outcome_.first->tick) + " first";
  }
  if (!outcome_.sameStep) words += "; it was made by another version of the step";
  if (outcome_.refusal) words += "; it ends early: " + printable(outcome_.refusal->text());
  if (!endedEarly_.empty()) words += "; it ends early: " + printable(endedEarly_);
  if (outcome_.cutOff) words += "; it was cut off while it was being written";
  return words;
}

std::string RecordedSession::extent() const {
  return std::to_string(moments_.list().size()) + " of " + std::to_string(outcome_.ticks) + " ticks are shown, " +
         std::to_string(std::lround(1 / moments_.interval_s())) + " a second at most; " +
         std::to_string(marks_.size()) + (marks_.size() == 1 ? " mark" : " marks");
}

std::string RecordedSession::status(double time_s) const {
  return "replay of " + name_ + ", " + seconds(time_s) + " of " + seconds(duration_s()) + "; " + verdict();
}

std::shared_ptr<const MirrorView> RecordedSession::view(std::size_t moment, std::uint64_t now_ns) const {
  const RecordedMoment& shown = moments_.list()[moment];
  auto view = std::make_shared<MirrorView>(*scenes_[shown.scene]);
  view->link = LinkState::kLive;
  view->isReplay = true;
  view->linkText = status(shown.time_s);
  view->sample = shown.sample;
  view->secondHand = shown.secondHand;
  view->takenAt_ns = now_ns;
  view->serverName = "recording of " + outcome_.facts.server;
  view->device = outcome_.facts.device;
  view->maxForce_N = outcome_.facts.config.maxForce_N;
  if (const auto& second = outcome_.facts.secondHand) {
    view->secondDevice = second->device;
    view->secondMaxForce_N = second->config.maxForce_N;
  }
  view->servoRate_Hz = outcome_.facts.rate_Hz;
  view->connections = 1;
  view->samplesReceived = moment + 1;
  if (!shown.motion) return view;
  for (const BodyState& body : shown.motion->bodies) {
    if (view->scene->find(body.object)) view->bodies[body.object] = body;
  }
  view->dents = shown.motion->dents;
  if (shown.motion->tool.object != 0) view->tool = shown.motion->tool;
  return view;
}

}  // namespace haptics
