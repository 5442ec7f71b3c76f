#include "haptic_server/recording/flight_recorder.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <iterator>
#include <system_error>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/clock/unix_time.h"
#include "haptic_server/recording/last_seconds.h"
#include "haptics/v1/telemetry.pb.h"

namespace haptics {
namespace {

/// Scenes that the servo may have used within what the ring holds, a stop of the recorder included.
constexpr std::uint64_t kHoldScenes_ns = 30'000'000'000;
/// Bytes of scenes that are not held any more, beyond as many as are.
constexpr std::uint64_t kJournalSlack_bytes = 4U << 20;

/// "device_lost"
[[nodiscard]] std::string nameOf(Fault fault) {
  std::string name = v1::Fault_Name(static_cast<v1::Fault>(fault)).substr(std::string("FAULT_").size());
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Canonical.
[[nodiscard]] std::size_t assetBytes(const SceneSource& scene) {
  std::size_t bytes = 0;
  for (const ServoObjectSource& object : scene.objects) {
    const ObjectAssets& assets = object.assets;
    if (assets.mesh) bytes += assets.mesh->bytes().size();
    for (const auto& other : assets.others) bytes += other->bytes().size();
  }
  return bytes;
}

}  // namespace

Result<std::unique_ptr<FlightRecorder>> FlightRecorder::open(Options options, FlightRing& ring) {
  std::unique_ptr<FlightRecorder> recorder(new FlightRecorder(std::move(options), ring));
  recorder->stateDue_ = recorder->options_.ticksPerState;
  if (const std::string& file = recorder->options_.record; !file.empty()) {
    RecordingFacts facts = recorder->options_.facts;
    facts.began_unix_ns = unixNow_ns();
    facts.why = "--record";
    auto writer = RecordingWriter::create(file, facts);
    if (!writer) return tl::unexpected(std::move(writer.error()));
    recorder->writer_ = *std::move(writer);
  }
  if (recorder->options_.checkReplay) recorder->check_.emplace(recorder->options_.facts, recorder->options_.warning);
  if (recorder->options_.keepScenes) recorder->keep(nullptr);
  return recorder;
}

FlightRecorder::~FlightRecorder() { (void)stop(); }

void FlightRecorder::onSceneBuilt(const ServoScene& scene, const std::vector<ServoObjectSource>& objects) {
  const std::uint64_t now_ns = monotonicNow_ns();
  const auto kept = std::make_shared<const SceneSource>(SceneSource{scene.number, scene.revision, objects});
  std::list<Held> held{{kept, now_ns}};
  std::list<std::shared_ptr<const SceneSource>> toKeep{kept};
  bool later = false, running = false;
  {
    const std::lock_guard lock(mutex_);
    scenes_.splice(scenes_.end(), held);
    running = running_;
    later = running && (!toKeep_.empty() || assetBytes(*kept) > kKeptAtOnce_bytes);
    if (later && options_.keepScenes) toKeep_.splice(toKeep_.end(), toKeep);
  }
  if (!running) releaseScenes();  // else the recorder's thread does, which may take its time
  if (!later && options_.keepScenes) keep(kept.get());
}

/// What onSceneBuilt() left to this thread.
void FlightRecorder::keepDue() {
  std::unique_lock lock(mutex_);
  while (!toKeep_.empty()) {
    const auto scene = toKeep_.front();
    lock.unlock();
    keep(scene.get());
    lock.lock();
    toKeep_.pop_front();
  }
}

/// Into the journal; a new one where most of it is of scenes that are not held any more, or there is none yet.
void FlightRecorder::keep(const SceneSource* scene) {
  if (!keepsScenes_) return;
  Result<void> kept;
  try {
    const bool full = !journal_ || journal_->size() > 2 * journalBegan_ + kJournalSlack_bytes;
    kept = full ? keepAnew(scene != nullptr ? scene->number : 0) : journal_->add(*scene);
  } catch (const std::exception& failure) {  // as without memory
    kept = refused("", failure.what());
  }
  if (kept) return;
  keepsScenes_ = false;
  options_.warning("from here on the last seconds before a crash cannot be kept: " + kept.error().text());
}

Result<void> FlightRecorder::keepAnew(std::uint64_t upTo) {
  auto journal = SceneJournal::make(options_.facts);
  if (!journal) return tl::unexpected(std::move(journal.error()));
  for (const auto& scene : scenesFrom(0)) {
    if (scene->number > upTo) break;
    if (auto added = journal->add(*scene); !added) return added;
  }
  journal_ = *std::move(journal);
  journalBegan_ = journal_->size();
  options_.keepScenes(journal_->descriptor());
  return {};
}

void FlightRecorder::releaseScenes() {
  const std::uint64_t now_ns = monotonicNow_ns();
  std::list<Held> old;  // freed without the lock
  const std::lock_guard lock(mutex_);
  while (scenes_.size() > 1 && std::next(scenes_.begin())->built_ns + kHoldScenes_ns < now_ns)
    old.splice(old.end(), scenes_, scenes_.begin());
}

void FlightRecorder::start() {
  {
    const std::lock_guard lock(mutex_);
    running_ = true;
  }
  thread_ = std::thread([this] { run(); });
}

void FlightRecorder::request(std::string why, Answer answer) {
  {
    const std::lock_guard lock(mutex_);
    asked_.push_back({std::move(why), std::move(answer), ring_.end()});
  }
  changed_.notify_one();
}

Result<void> FlightRecorder::stop() {
  if (thread_.joinable()) {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_one();
    thread_.join();
    look(true);
    if (check_) check_->finish();
  }
  if (failure_) return tl::unexpected(*failure_);
  return {};
}

void FlightRecorder::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    changed_.wait_for(lock, std::chrono::nanoseconds(kFlushEvery_ns));
    lock.unlock();
    look(false);
    lock.lock();
  }
}

void FlightRecorder::look(bool last) {
  // Scenes are given before ticks take them: looked for after the ticks, all that these name are there.
  const std::uint64_t end = ring_.end();
  try {
    takeTicks(end);
    writeDue(end, last);
    keepDue();
    releaseScenes();
  } catch (const std::exception& failure) {  // as without memory
    if (writer_) giveUp(failure.what());
    if (check_) check_->endRun();
  }
}

void FlightRecorder::takeTicks(std::uint64_t end) {
  if (writer_) addScenes(*writer_, writer_->scene() + 1);
  if (RecordingEncoder* checked = check_ ? check_->encoder() : nullptr) addScenes(*checked, checked->scene() + 1);
  std::array<RecordedTick, kMaxHands> ticks;
  const auto tick = std::span(ticks).first(ring_.hands());
  std::optional<FlightRing::HeldKeyframes> keyframes;
  if (check_ || (writer_ && end > stateDue_)) keyframes.emplace(ring_);
  for (; seen_ < end; ++seen_) {
    if (keyframes) addState(*keyframes);
    if (ring_.read(seen_, tick)) {
      take(tick);
    } else {
      if (check_) check_->flush(false);
      if (writer_)
        giveUp("the disk was slower than the servo for " + std::to_string(static_cast<int>(FlightRing::kSeconds)) +
               " s; the recording ends there");
    }
  }
  keyframes.reset();
  if (check_) check_->flush();
  if (writer_) {
    if (auto flushed = writer_->flush(); !flushed) giveUp(flushed.error().reason);
  }
}

/// The state before the next tick, where a keyframe has it.
void FlightRecorder::addState(const FlightRing::HeldKeyframes& keyframes) {
  const auto keyframe = keyframes.atOrBefore(seen_);
  if (keyframe.empty() || keyframe.front().position != seen_) return;
  if (check_) check_->add(keyframe, [this](RecordingEncoder& to, std::uint64_t from) { addScenes(to, from); });
  if (!writer_ || seen_ < stateDue_) return;
  writer_->add(keyframe);
  stateDue_ = seen_ + options_.ticksPerState;
}

void FlightRecorder::take(std::span<const RecordedTick> tick) {
  if (writer_) writer_->add(tick);
  if (check_) check_->add(tick);
  for (std::size_t hand = 0; hand < tick.size(); ++hand) {
    const Fault fault = tick[hand].fault;
    const bool wasGood = std::exchange(wasGood_[hand], fault == Fault::kNone);
    if (!wasGood || fault == Fault::kNone || !mayBeRecorded(fault)) continue;
    ++faults_;
    const auto after = static_cast<std::uint64_t>(std::ceil(kAfterFault_s * options_.facts.rate_Hz));
    due_.push_back({nameOf(fault), {}, seen_ + after});
  }
}

bool FlightRecorder::mayBeRecorded(Fault fault) {
  if (faults_ >= kMaxFaults) return false;
  const std::uint64_t now_ns = monotonicNow_ns();
  if (now_ns >= nextFault_ns_) return true;
  options_.info("no recording of this fault (" + nameOf(fault) +
                "): the last one was so large that the next can be made in " +
                std::to_string((nextFault_ns_ - now_ns) / 1'000'000'000 + 1) + " s");
  return false;
}

void FlightRecorder::pauseAfter(const std::filesystem::path& recording) {
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(recording, unknown);
  if (unknown) return;
  nextFault_ns_ = monotonicNow_ns() + static_cast<std::uint64_t>(1e9 * static_cast<double>(bytes) / kFaultBytes_per_s);
}

void FlightRecorder::writeDue(std::uint64_t end, bool last) {
  {
    const std::lock_guard lock(mutex_);
    std::ranges::move(asked_, std::back_inserter(due_));
    asked_.clear();
  }
  for (const Request& request : std::exchange(due_, {})) {
    if (!last && request.due > end) {
      due_.push_back(request);
      continue;
    }
    if (!mayBeGranted(request)) continue;
    const auto addTo = [this](RecordingWriter& writer, std::uint64_t from) { addScenes(writer, from); };
    const auto written =
        recordLastSeconds({options_.folder, options_.quota}, request.why, options_.facts, ring_, addTo);
    if (request.answer) request.answer(written);
    if (written) {
      if (!request.answer) pauseAfter(*written);
      options_.info("the last " + std::to_string(static_cast<int>(FlightRing::kSeconds)) + " s are in " +
                    written->string() + " (" + request.why + ')');
    } else {
      options_.warning("the last seconds could not be kept: " + written.error().text());
    }
  }
}

bool FlightRecorder::mayBeGranted(const Request& request) {
  if (!request.answer) return true;
  const std::uint64_t now_ns = monotonicNow_ns();
  if (requested_ns_ != 0 && now_ns - requested_ns_ < kBetweenRequests_ns) {
    request.answer(refused("", "the last seconds were recorded just now; ask again in a second"));
    return false;
  }
  requested_ns_ = now_ns;
  return true;
}

std::vector<std::shared_ptr<const SceneSource>> FlightRecorder::scenesFrom(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<const SceneSource>> scenes;
  for (const Held& held : scenes_) {
    if (held.scene->number >= number) scenes.push_back(held.scene);
  }
  return scenes;
}

void FlightRecorder::addScenes(RecordingEncoder& to, std::uint64_t from) const {
  for (const auto& scene : scenesFrom(from)) to.add(*scene);
}

void FlightRecorder::giveUp(const std::string& why) {
  failure_ = Error{options_.record, "the recording is incomplete: " + why};
  options_.warning(failure_->text());
  writer_.reset();
}

}  // namespace haptics
