#include "haptic_server/scene/work_notes.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>

#include "common/clock/monotonic.h"

namespace haptics {
namespace {

constexpr std::array<char, 16> kHead{"haptics work 1"};
constexpr std::chrono::milliseconds kBeatEvery{100};
constexpr std::uint32_t kFree = 0, kTaken = 1, kAtWork = 2;

using Boot = std::array<char, 40>;

Boot thisBoot() {
  Boot boot{};
  std::ifstream("/proc/sys/kernel/random/boot_id").read(boot.data(), boot.size() - 1);
  return boot;
}

/// A file of this size whose space is there: a write to it through memory cannot fail.
std::optional<SharedMemory> mapFile(const std::filesystem::path& file, std::size_t size) {
  FileHandle handle(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  struct stat about {};
  if (!handle || ::fstat(handle.descriptor(), &about) != 0 || !S_ISREG(about.st_mode)) return std::nullopt;
  if (::ftruncate(handle.descriptor(), static_cast<off_t>(size)) != 0) return std::nullopt;
  if (::posix_fallocate(handle.descriptor(), 0, static_cast<off_t>(size)) != 0) return std::nullopt;
  auto mapped = SharedMemory::map(std::move(handle), size);
  return mapped ? std::optional(*std::move(mapped)) : std::nullopt;
}

}  // namespace

struct WorkNotes::Slot {
  std::atomic<std::uint32_t> state;
  Key key;
  std::uint64_t began_ns;
};

struct WorkNotes::Page {
  std::array<char, 16> head;
  Boot boot;                           // of the machine
  std::atomic<std::uint64_t> beat_ns;  // when the process was there last
  std::atomic<std::uint32_t> crashed;
  std::uint32_t deadlyCount;  // ever; the newest overwrite the oldest
  std::array<Key, kMaxDeadly> deadly;
  std::array<Slot, kMaxAtOnce> atWork;
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free);
};

std::unique_ptr<WorkNotes> WorkNotes::open(const std::filesystem::path& file) {
  auto mapped = mapFile(file, sizeof(Page));
  if (!mapped) return nullptr;
  return std::unique_ptr<WorkNotes>(new WorkNotes(*std::move(mapped)));
}

WorkNotes::WorkNotes(SharedMemory file) : file_(std::move(file)) {
  takeOver();
  beat_ = std::jthread([this](const std::stop_token& done) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    while (!done.stop_requested()) {
      page().beat_ns.store(monotonicNow_ns(), std::memory_order_relaxed);
      never.wait_for(lock, done, kBeatEvery, [] { return false; });
    }
  });
}

/// From the server before.
void WorkNotes::takeOver() {
  Page& its = page();
  if (its.head != kHead) {
    std::ranges::fill(file_.bytes(), std::byte{0});
    its.head = kHead;
  }
  const Boot boot = thisBoot();
  const bool crashed = its.crashed.load() != 0;
  for (Slot& slot : its.atWork) {
    const bool wasAtWork = slot.state.exchange(kFree) == kAtWork && its.boot == boot;
    if (!wasAtWork || isDeadly(slot.key)) continue;
    if (!crashed && its.beat_ns.load() < slot.began_ns + kLong_ns) continue;
    its.deadly[its.deadlyCount++ % kMaxDeadly] = slot.key;
    diedAt_.push_back(slot.key);
  }
  its.crashed = 0;
  its.boot = boot;
}

WorkNotes::Page& WorkNotes::page() const noexcept { return *reinterpret_cast<Page*>(file_.bytes().data()); }

std::atomic<std::uint32_t>& WorkNotes::crashFlag() const noexcept { return page().crashed; }

void WorkNotes::endsInOrder() noexcept { page().boot = {}; }

bool WorkNotes::isDeadly(const Key& key) const noexcept {
  return key != Key{} && std::ranges::count(page().deadly, key) > 0;
}

/// Null: there are too many.
WorkNotes::Slot* WorkNotes::takeSlot(const Key& key) noexcept {
  for (Slot& slot : page().atWork) {
    std::uint32_t free = kFree;
    if (!slot.state.compare_exchange_strong(free, kTaken)) continue;
    slot.key = key;
    slot.began_ns = monotonicNow_ns();
    slot.state.store(kAtWork, std::memory_order_release);
    return &slot;
  }
  return nullptr;
}

WorkNotes::UnderWay::UnderWay(WorkNotes* notes, const Key& key) noexcept
    : slot_(notes == nullptr || key == Key{} ? nullptr : notes->takeSlot(key)) {}

WorkNotes::UnderWay::~UnderWay() {
  if (slot_ != nullptr) slot_->state.store(kFree, std::memory_order_release);
}

}  // namespace haptics
