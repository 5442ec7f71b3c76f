#include "haptic_server/state/state_scrubber.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <span>
#include <string>
#include <utility>

#include "haptic_server/state/durable_file.h"

namespace haptics {
namespace {

constexpr std::size_t kPiece_bytes = 64U << 10;

/// Whether or not the system lets it: then it costs a little more. Not SCHED_IDLE, nor that class of the disk: on a busy machine
/// such a thread does not run for seconds, not even to end, and the process cannot end without it.
void giveWay() {
  constexpr int kNice = 10;
  pthread_setname_np(pthread_self(), "scrubber");
  (void)::setpriority(PRIO_PROCESS, 0, kNice);  // this thread's
  constexpr int kOfThisThread = 1, kBestEffort = 2, kLast = 7, kClassShift = 13;
  (void)::syscall(SYS_ioprio_set, kOfThisThread, 0, kBestEffort << kClassShift | kLast);
}

}  // namespace

StateScrubber::StateScrubber(Options options) : options_(std::move(options)), thread_([this] { run(); }) {}

StateScrubber::~StateScrubber() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

/// False: it is to stop.
bool StateScrubber::wait(std::chrono::nanoseconds time) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, time, [this] { return stopping_; });
}

void StateScrubber::run() {
  giveWay();
  while (wait(options_.pause)) {
    try {
      scrub();
    } catch (const std::exception&) {  // for want of memory: later, anew
    }
  }
}

/// All files once.
void StateScrubber::scrub() {
  scrubLog("log");
  if (!wait(options_.pause)) return;
  scrubLog("checkpoint");
  auto assets = options_.assets();
  std::ranges::sort(assets);
  assets.erase(std::unique(assets.begin(), assets.end()), assets.end());
  for (const ContentHash& asset : assets) {
    if (!wait(options_.pause)) return;
    scrubAsset(asset);
  }
}

/// False: it was not read to its end, because it cannot be or this is to stop.
template <class Take>
bool StateScrubber::readSlowly(const std::filesystem::path& file, Take take) {
  const FileHandle handle(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // of a pipe, too
  struct stat about {};
  if (!handle || ::fstat(handle.descriptor(), &about) != 0 || !S_ISREG(about.st_mode)) return false;
  (void)::posix_fadvise(handle.descriptor(), 0, 0, POSIX_FADV_DONTNEED);
  std::string piece(kPiece_bytes, '\0');
  const auto pause = std::chrono::nanoseconds(std::chrono::seconds(1)) * kPiece_bytes / options_.rate_bytes_per_s;
  for (;;) {
    const ssize_t got = ::read(handle.descriptor(), piece.data(), piece.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    take(std::string_view(piece).substr(0, static_cast<std::size_t>(got)));
    if (!wait(pause)) return false;
  }
  (void)::posix_fadvise(handle.descriptor(), 0, 0, POSIX_FADV_DONTNEED);
  return true;
}

/// Nothing: it could not be read.
std::optional<StateScrubber::LogCheck> StateScrubber::checkLog(const std::filesystem::path& file) {
  std::string bytes;
  if (!readSlowly(file, [&](std::string_view piece) { bytes += piece; })) return std::nullopt;
  if (!bytes.starts_with(kLogHead)) return LogCheck{LogEnd::kDamaged, 0};
  RecordReader reader(bytes);
  std::size_t records = 0;
  while (reader.next()) ++records;
  return LogCheck{records == 0 ? LogEnd::kDamaged : reader.end(), reader.offset()};
}

/// A log that does not look whole may be one that is being written. It is damaged if it stays so.
void StateScrubber::scrubLog(const char* name) {
  const std::filesystem::path file = options_.folder / name;
  const auto first = checkLog(file);
  if (first && first->end == LogEnd::kWhole) {
    reported_.erase(file);
    return;
  }
  if (wait(options_.pause) && checkLog(file) == first && wait({})) report(file, std::nullopt);
}

void StateScrubber::scrubAsset(const ContentHash& asset) {
  const std::filesystem::path file = options_.folder / "assets" / asset.hex();
  Hasher hasher;
  const bool read = readSlowly(file, [&](std::string_view piece) { hasher.add(std::as_bytes(std::span(piece))); });
  if (read && hasher.finish() == asset) {
    reported_.erase(file);
    return;
  }
  // It may have gone with the object that named it.
  if (wait({}) && std::ranges::count(options_.assets(), asset) > 0) report(file, asset);
}

void StateScrubber::report(const std::filesystem::path& file, const std::optional<ContentHash>& asset) {
  if (!reported_.contains(file) && options_.repair(file, asset)) reported_.insert(file);
}

}  // namespace haptics
