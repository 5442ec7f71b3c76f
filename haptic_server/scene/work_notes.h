#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "common/process/shared_memory.h"

namespace haptics {

/// What a server is working at, in a file that outlives it: the next server then knows at what the last one died, and does
/// not try that again when a client sends it again. The file is mapped: a note costs no system call, and is there however
/// the process ends. Work counts as deadly where the process ended by a signal of its own making (crashFlag()), and
/// otherwise, as when the system killed it for its memory, once it has taken kLong_ns. What a machine that went down was at
/// does not count. Thread-safe.
class WorkNotes {
 public:
  /// Whose work it is: of an edit, its session and client_seq; of an upload, its session and the first bytes of its hash. Another
  /// session, as of a client that was started anew, may try the same work once more.
  struct Key {
    std::uint64_t first = 0, second = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };
  static constexpr std::uint64_t kLong_ns = 1'000'000'000;
  static constexpr std::size_t kMaxAtOnce = 96;  ///< More at once are not noted.
  static constexpr std::size_t kMaxDeadly = 64;  ///< The newest are remembered.

  /// Makes the file when there is none, or one of another layout. Null: it cannot be had, and nothing is noted.
  [[nodiscard]] static std::unique_ptr<WorkNotes> open(const std::filesystem::path& file);
  WorkNotes(const WorkNotes&) = delete;
  WorkNotes& operator=(const WorkNotes&) = delete;

  struct Slot;
  /// While it lives, the work is under way.
  class UnderWay {
   public:
    UnderWay(WorkNotes* notes, const Key& key) noexcept;  ///< Of no notes, or key, nothing is noted.
    ~UnderWay();
    UnderWay(UnderWay&& other) noexcept : slot_(std::exchange(other.slot_, nullptr)) {}
    UnderWay& operator=(UnderWay&&) = delete;

   private:
    Slot* slot_ = nullptr;
  };

  /// A server of this folder has died at it.
  [[nodiscard]] bool isDeadly(const Key& key) const noexcept;
  [[nodiscard]] const std::vector<Key>& diedAt() const noexcept { return diedAt_; }  ///< The last server.
  /// The process is about to end as it should: what it is at is not at fault.
  void endsInOrder() noexcept;
  /// To be set in the handler of a signal that ends the process.
  [[nodiscard]] std::atomic<std::uint32_t>& crashFlag() const noexcept;

 private:
  struct Page;
  explicit WorkNotes(SharedMemory file);
  [[nodiscard]] Page& page() const noexcept;
  [[nodiscard]] Slot* takeSlot(const Key& key) noexcept;
  void takeOver();

  SharedMemory file_;
  std::vector<Key> diedAt_;
  std::jthread beat_;
};

}  // namespace haptics
