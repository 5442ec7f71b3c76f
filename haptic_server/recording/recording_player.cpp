#include "haptic_server/recording/recording_player.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

namespace haptics {
namespace {

/// Between looks at how far the servo is: later, those who watch see an edit later.
constexpr std::chrono::milliseconds kLookEvery{5};

[[nodiscard]] tl::unexpected<Error> within(const std::filesystem::path& file, Error error) {
  return tl::unexpected(std::move(error).within(file.string() + (error.field.empty() ? "" : ": ")));
}

}  // namespace

RecordingPlayer::RecordingPlayer(std::filesystem::path path, RecordingBytes bytes, RecordingFacts facts)
    : path_(std::move(path)), bytes_(std::move(bytes)), facts_(std::move(facts)) {
  devices_.emplace_back(facts_.device, facts_.config, *this, 0);
  if (facts_.secondHand) devices_.emplace_back(facts_.secondHand->device, facts_.secondHand->config, *this, 1);
}

RecordingPlayer::RecordedDevice::RecordedDevice(const std::string& name, const StepConfig& config,
                                                RecordingPlayer& player, std::size_t hand)
    : player_(player), hand_(hand) {
  info_.name = "recording of " + name;
  info_.maxForce_N = config.maxForce_N;
  info_.resolution_m = config.positionStep_m;
}

Result<std::unique_ptr<RecordingPlayer>> RecordingPlayer::open(const std::filesystem::path& path) {
  auto bytes = RecordingBytes::open(path);
  if (!bytes) return within(path, bytes.error());
  const auto reader = RecordingReader::open(*bytes);
  if (!reader) return within(path, reader.error());
  return std::unique_ptr<RecordingPlayer>(new RecordingPlayer(path, *std::move(bytes), reader->facts()));
}

Result<void> RecordingPlayer::prepare(AssetStore& store, Show show) {
  auto run = RecordedRun::open(bytes_, store);
  if (!run) return tl::unexpected(std::move(run.error()));
  run_ = *std::move(run);
  show_ = std::move(show);
  readOne();
  if (refusal_) return tl::unexpected(*refusal_);
  if (read_ == 0) return refused(path_.string(), "ends before its first tick");
  for (const ServoScene* scene : {beginning().scene, beginning().pending}) {
    if (scene != nullptr) (void)show_(*run_->find(scene->number));
  }
  showTaken(1);
  return {};
}

void RecordingPlayer::start() {
  thread_ = std::thread([this] { run(); });
}

void RecordingPlayer::finish() {
  quit_ = true;
  if (thread_.joinable()) thread_.join();
}

void RecordingPlayer::run() {
  try {
    playOn();
  } catch (const std::exception& failure) {  // as without the memory for a scene
    refusal_ = Error{path_.string(), std::string("is not played or shown any further: ") + failure.what()};
    readAll_.store(true, std::memory_order_release);
  }
}

void RecordingPlayer::playOn() {
  while (!quit_) {
    showTaken(played_.ticks.load(std::memory_order_acquire));
    const std::uint64_t used = used_.load(std::memory_order_acquire);
    run_->releaseBefore(toShow_.empty() ? used : std::min(used, toShow_.front().scene));
    while (!quit_ && !readAll_ && ahead_.write_available() > 0) readOne();
    std::this_thread::sleep_for(kLookEvery);
  }
}

void RecordingPlayer::readOne() {
  auto tick = run_->next();
  if (!tick) refusal_ = within(path_, tick.error()).value();
  if (!tick || !*tick) {
    readAll_.store(true, std::memory_order_release);
    return;
  }
  if ((*tick)->given != nullptr) toShow_.push_back({read_, (*tick)->given->scene->number});
  ahead_.push(**tick);
  ++read_;
}

void RecordingPlayer::showTaken(std::uint64_t ticks) {
  while (!toShow_.empty() && toShow_.front().position < ticks) {
    if (!show_(*run_->find(toShow_.front().scene))) return;
    toShow_.pop_front();
  }
}

ReplaySource::Next RecordingPlayer::next(Tick& tick) noexcept {
  const bool all = readAll_.load(std::memory_order_acquire);
  if (!ahead_.pop(now_)) {
    if (!all) return Next::kNotYet;
    played_.toItsEnd.store(true, std::memory_order_relaxed);
    return Next::kEnd;
  }
  tick = {now_.recorded[0].input.tick, now_.given != nullptr ? now_.given->scene.get() : nullptr};
  return Next::kTick;
}

void RecordingPlayer::compare(std::size_t hand, Vec3 force_N, Vec3 torque_Nm, double grip_Nm) noexcept {
  const RecordedTick& recorded = now_.recorded[hand];
  const bool differs = !wroteSame(recorded, force_N, torque_Nm, grip_Nm);
  differs_ = differs || (hand > 0 && differs_);
  if (hand + 1 < facts_.hands()) return;
  if (differs_) {
    if (played_.differing.load(std::memory_order_relaxed) == 0) played_.firstTick = recorded.input.tick;
    played_.differing.fetch_add(1, std::memory_order_relaxed);
  }
  played_.ticks.fetch_add(1, std::memory_order_release);
}

Result<std::string> RecordingPlayer::verdict() const {
  const std::string ticks = std::to_string(played_.ticks) + " ticks";
  const bool toItsEnd = played_.toItsEnd;
  if (played_.differing > 0) {
    return refused(path_.string(), std::to_string(played_.differing) + " of " + ticks +
                                       " came to another force or torque than the recorded one, tick " +
                                       std::to_string(played_.firstTick) + " first" +
                                       (sameStep() ? "" : "; it was recorded by another version of the step"));
  }
  if (toItsEnd && refusal_) return tl::unexpected(Error(*refusal_).within("played " + ticks + ", then: "));
  std::string said = path_.string() + ": played " + ticks + "; every force was the recorded one, bit for bit";
  if (!toItsEnd) said += "; stopped before its end";
  if (toItsEnd && run_->cutOff())
    said += "; it was cut off while it was being written, and ends with its last whole part";
  return said;
}

}  // namespace haptics
