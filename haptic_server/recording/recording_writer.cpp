#include "haptic_server/recording/recording_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "common/process/pending_file.h"
#include "haptic_server/recording/state_image.h"

namespace haptics {
namespace {

constexpr int kPermissions = 0666;  // less the umask
constexpr std::size_t kMaxPending_bytes = 4U << 20;

[[nodiscard]] tl::unexpected<Error> failed(const std::filesystem::path& file) {
  return refused(file.string(), "the recording cannot be written: " + std::generic_category().message(errno));
}

}  // namespace

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& file, const RecordingFacts& facts) {
  // It has its name once its head is written: one that others read is not to be cut short. Where there can be no other file
  // beside it, it is written as it is.
  PendingFile pending(file);
  const auto opened = [](const std::filesystem::path& path) {
    return FileHandle(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kPermissions));
  };
  FileHandle handle = opened(pending.place());
  const bool isBeside = static_cast<bool>(handle);
  if (!isBeside) handle = opened(file);
  if (!handle) return failed(file);
  RecordingWriter writer(file, std::move(handle));
  writer.pending_ = kRecordingHead;
  v1::RecordingPart part;
  *part.mutable_head() = toMessage(facts);
  writer.put(part);
  auto written = writer.flush();
  if (written && isBeside) written = pending.finish();
  if (!written) return tl::unexpected(std::move(written).error());
  return writer;
}

void RecordingEncoder::add(std::span<const Keyframe> keyframes) {
  putTicks();
  v1::RecordingPart part;
  v1::RecordedState* message = part.mutable_state();
  for (const Keyframe& keyframe : keyframes) {
    if (&keyframe != keyframes.data()) message = message->mutable_second_hand();
    message->set_scene(keyframe.scene);
    message->set_pending(keyframe.pending);
    message->set_image(stateImage(keyframe.state));
  }
  put(part);
}

void RecordingEncoder::Ticks::add(const RecordedTick& tick) {
  appendTick(tick, ticks);
  appendTurn(tick, turns);
  anyTurns = anyTurns || haptics::turns(tick);
  appendHandle(tick.handle, handles);
  anyHandles = anyHandles || tick.handle.measured != 0;
  appendWrench(tick.added, wrenches);
  anyWrenches = anyWrenches || !(tick.added == Wrench{});
  appendGrip(tick.grip_Nm, grips);
  anyGrips = anyGrips || tick.grip_Nm != 0;
}

void RecordingEncoder::Ticks::moveTo(v1::RecordedTicks& message) {
  message.set_ticks(std::exchange(ticks, {}));
  if (std::exchange(anyTurns, false)) message.set_turns(turns);
  turns.clear();
  if (std::exchange(anyHandles, false)) message.set_handles(handles);
  handles.clear();
  if (std::exchange(anyWrenches, false)) message.set_wrenches(wrenches);
  wrenches.clear();
  if (std::exchange(anyGrips, false)) message.set_grips(grips);
  grips.clear();
}

void RecordingEncoder::putTicks() {
  if (ticks_[0].ticks.empty()) return;
  v1::RecordingPart part;
  ticks_[0].moveTo(*part.mutable_ticks());
  if (!ticks_[1].ticks.empty()) ticks_[1].moveTo(*part.mutable_ticks()->mutable_second_hand());
  put(part);
}

Result<void> RecordingWriter::flush() {
  putTicks();
  writePending();
  if (failure_) return tl::unexpected(*failure_);
  return {};
}

void RecordingWriter::addPart(std::string_view part) {
  chain_.append(pending_, part);
  if (pending_.size() > kMaxPending_bytes) writePending();
}

void RecordingWriter::writePending() {
  std::string_view left = pending_;
  while (!left.empty() && !failure_) {
    const ssize_t written = ::write(handle_.descriptor(), left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      failure_ = failed(file_).value();
      (void)::ftruncate(handle_.descriptor(), static_cast<off_t>(size_));
      return;
    }
    left.remove_prefix(static_cast<std::size_t>(written));
  }
  if (!failure_) size_ += pending_.size();
  pending_.clear();
}

}  // namespace haptics
