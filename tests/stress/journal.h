#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/hash/content_hash.h"

namespace haptics::stress {

/// What a client writes down as it happens. A record is one write: a client that is killed leaves whole records.
struct Record {
  enum class Kind : std::uint32_t {
    kSubmitted,  ///< number: of the edit; value: what the counter becomes, 0 for an edit of the client's own mark.
    kAccepted,   ///< likewise; revision.
    kConflict,   ///< number.
    kRejected,   ///< number.
    kView,       ///< revision, root; age_ns where measured.
    kLink,       ///< number: connections so far; value: resyncs; revision: state resets.
    kGap,        ///< a commit that did not follow the one before; revision.
    kFinal,      ///< revision, and the root computed anew from every byte.
  };
  enum Flags : std::uint32_t { kLive = 1, kAgeKnown = 2, kEqual = 4, kByDatagram = 8 };

  std::uint64_t time_ns = 0;
  Kind kind{};
  std::uint32_t flags = 0;
  std::uint64_t number = 0, revision = 0, value = 0;
  std::int64_t age_ns = 0;          ///< Of the newest sample, on the host's clock.
  std::int64_t ageByClient_ns = 0;  ///< By the client's estimate of the server's clock; 0 while it has none.
  ContentHash root{};
};
static_assert(std::is_trivially_copyable_v<Record>);

class Journal {
 public:
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  void write(const Record& record) const;  ///< Any thread.

 private:
  int file_;
};

[[nodiscard]] std::vector<Record> readJournal(const std::filesystem::path& file);

}  // namespace haptics::stress
