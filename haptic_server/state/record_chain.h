#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "common/hash/content_hash.h"

// A log's bytes: its head, a line that says what it is, then records:
//
//   u32 length of the payload | 4 bytes of SHA-256(chain, length) | payload | SHA-256(chain, all of these)
//
// little-endian, where the chain is the hash of the record before, and of the head for the first. A record is therefore
// bound to all before it: one that was damaged, left out, repeated or moved is found, and so is each record after it.
// The short check of the length tells a record that was cut off, whose length is right, from a damaged one. A file
// whose size was written and whose bytes were not has zeros in their place.
namespace haptics {

inline constexpr std::string_view kLogHead = "haptics state 1\n";

/// Writes records, each after the one before.
class RecordWriter {
 public:
  explicit RecordWriter(std::string_view head = kLogHead);  ///< Of the first record, after the head.
  explicit RecordWriter(const ContentHash& chain);          ///< Goes on where a reader is.
  void append(std::string& out, std::string_view payload);  ///< The payload is at most 4 GiB.

 private:
  ContentHash chain_;
};

enum class LogEnd {
  kWhole,  ///< After the last record.
  kTorn,   ///< Within the last record: the bytes end before it does, or nothing but zeros is in its place or its rest.
  kDamaged,  ///< At a record that is not what was written.
};

/// Reads records as far as they are whole.
class RecordReader {
 public:
  /// All of a log, its head included, which the caller has checked; outlives the reader.
  explicit RecordReader(std::string_view log, std::string_view head = kLogHead);
  /// A log's bytes from a record on, where a reader is that has this chain.
  RecordReader(std::string_view rest, const ContentHash& chain);

  /// The next record's payload; nothing at the end, whichever it is.
  [[nodiscard]] std::optional<std::string_view> next();
  [[nodiscard]] LogEnd end() const noexcept { return end_; }  ///< Once next() has returned nothing.
  /// Likewise: the bytes of the record that the end is in, 0 where its head is not whole or not right.
  [[nodiscard]] std::size_t needed() const noexcept { return needed_; }
  [[nodiscard]] std::size_t offset() const noexcept {
    return offset_;
  }  ///< Bytes of the head, where there is one, and the records read.
  [[nodiscard]] const ContentHash& chain() const noexcept { return chain_; }  ///< To append after them.

 private:
  std::string_view log_;
  std::size_t offset_;
  std::size_t needed_ = 0;
  ContentHash chain_;
  LogEnd end_ = LogEnd::kWhole;
};

}  // namespace haptics
