#include "haptic_server/recording/recording_reader.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "haptic_server/recording/state_image.h"

namespace haptics {
namespace {

/// That are read at once, at least.
constexpr std::size_t kWindow_bytes = 1U << 20;
/// Protobuf reads no larger message.
constexpr std::size_t kMaxRecord_bytes = std::numeric_limits<int>::max();

}  // namespace

Result<RecordingReader> RecordingReader::open(RecordingBytes bytes) {
  std::string head;
  if (auto read = bytes.read(0, kRecordingHead.size(), head); !read) return tl::unexpected(std::move(read).error());
  if (head != kRecordingHead) {
    return refused("", "does not begin with \"" + std::string(kRecordingHead.substr(0, kRecordingHead.size() - 1)) +
                           "\": it is no recording of this version (haptic_server --record makes one)");
  }
  RecordingReader reader(std::move(bytes));
  reader.offset_ = head.size();
  reader.chain_ = RecordReader(head, head).chain();
  auto first = reader.next();
  if (!first) return tl::unexpected(std::move(first.error()));
  if (*first == nullptr || !(*first)->has_head())
    return refused("", "ends before it says what it is: the server was stopped while it began to record");
  auto facts = factsFrom((*first)->head());
  if (!facts) return tl::unexpected(std::move(facts.error()));
  reader.facts_ = *std::move(facts);
  reader.sameLayout_ = (*first)->head().state_layout() == stateLayout();
  return reader;
}

Result<const v1::RecordingPart*> RecordingReader::next() {
  const std::size_t at = offset_;
  const auto record = nextRecord();
  if (!record) return tl::unexpected(Error(record.error()).within("byte " + std::to_string(at)));
  const auto& payload = *record;
  if (!payload) {
    if (end_ == LogEnd::kDamaged)
      return refused("byte " + std::to_string(at), "is damaged: what follows is not what was written");
    return nullptr;
  }
  const bool parsed = part_.ParseFromArray(payload->data(), static_cast<int>(payload->size()));
  if (!parsed || part_.part_case() == v1::RecordingPart::PART_NOT_SET)
    return refused("byte " + std::to_string(at), "holds no part that this version knows");
  return &part_;
}

/// A record may seem to be torn because the window ends in it.
Result<std::optional<std::string_view>> RecordingReader::nextRecord() {
  while (true) {
    RecordReader records(std::string_view(window_).substr(inWindow_), chain_);
    const auto payload = records.next();
    if (payload) {
      offset_ += records.offset();
      inWindow_ += records.offset();
      chain_ = records.chain();
      end_ = LogEnd::kWhole;
      return payload;
    }
    end_ = records.end();
    if (end_ == LogEnd::kDamaged) return std::nullopt;
    window_ = window_.substr(std::exchange(inWindow_, 0));
    const std::size_t had = window_.size();
    if (records.needed() > kMaxRecord_bytes) return refused("", "holds a part of more than 2 GiB");
    if (had >= kWindow_bytes && records.needed() <= had) return endAtZeros();
    const std::size_t wanted = std::max(kWindow_bytes, records.needed() + kWindow_bytes - had);
    if (auto read = bytes_.read(offset_ + had, wanted, window_); !read) return tl::unexpected(std::move(read).error());
    if (window_.size() == had) return std::nullopt;
  }
}

/// The record is damaged unless nothing but zeros follows.
Result<std::optional<std::string_view>> RecordingReader::endAtZeros() {
  std::string piece;
  for (std::size_t at = offset_ + window_.size();; at += piece.size()) {
    piece.clear();
    if (auto read = bytes_.read(at, kWindow_bytes, piece); !read) return tl::unexpected(std::move(read).error());
    if (piece.empty()) return std::nullopt;
    if (piece.find_first_not_of('\0') == std::string::npos) continue;
    end_ = LogEnd::kDamaged;
    return std::nullopt;
  }
}

}  // namespace haptics
